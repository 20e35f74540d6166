"""Steering by the flow alone: balance and time to contact, on flows that are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from graphnav_steer.balance import Balance
from graphnav_steer.time_to_contact import Divergence, TimeToContact, inverse_time

from graphnav import Flow, Latest, Steering
from graphnav.arrays import Floats

ROWS, COLS = 120, 160
INTERVAL_US = 100_000
NONE: Latest[Any] = Latest()
ALL = slice(None)
BOTH: tuple[Divergence, ...] = ("full", "across")
STAGES: list[type[Balance | TimeToContact]] = [Balance, TimeToContact]
every_stage = pytest.mark.parametrize("cls", STAGES)


def flow(uv_px: Floats, valid: npt.ArrayLike = 1) -> Flow:
    grid = np.broadcast_to(np.asarray(valid, np.uint8), uv_px.shape[:2]).copy()
    return Flow(uv_px=np.ascontiguousarray(uv_px, np.float32), valid=grid, interval_us=INTERVAL_US)


def expanding(rate_per_s: float, columns: slice = ALL) -> Floats:
    """Return a flow that expands about the middle of some columns, and is zero in the others."""
    uv_px = np.zeros((ROWS, COLS, 2), np.float32)
    rows, cols = np.mgrid[:ROWS, :COLS].astype(np.float32)
    at = cols[:, columns]
    uv_px[:, columns, 0] = (at - at.mean()) * rate_per_s * INTERVAL_US * 1e-6
    uv_px[:, columns, 1] = (rows[:, columns] - rows.mean()) * rate_per_s * INTERVAL_US * 1e-6
    return uv_px


def downward(speed_px: float, faster: slice | None = None, times: float = 2.0) -> Floats:
    """Return what driving ahead over a floor gives, some columns of it ``times`` as fast."""
    uv_px = np.zeros((ROWS, COLS, 2), np.float32)
    uv_px[..., 1] = speed_px
    if faster is not None:
        uv_px[:, faster] *= times
    return uv_px


def mirrored(seen: Flow) -> Flow:
    return flow(seen.uv_px[:, ::-1] * np.array([-1, 1], np.float32), seen.valid[:, ::-1])


def steer(cls: type[Balance | TimeToContact], seen: Flow, **parameters: Any) -> Steering:
    stage = cls(**parameters)
    stage.reset(seed=0)
    return stage.step(seen, NONE, NONE)


OBSTACLE_RIGHT = {Balance: flow(downward(2.0, slice(110, 160))), TimeToContact: flow(expanding(0.5, slice(107, 160)))}


@every_stage
def test_obstacle_on_the_right_turns_the_robot_left(cls: type[Balance | TimeToContact]) -> None:
    as_is = steer(cls, OBSTACLE_RIGHT[cls])
    assert as_is.theta_rad > 0.05
    other = steer(cls, mirrored(OBSTACLE_RIGHT[cls]))
    assert other.theta_rad == pytest.approx(-as_is.theta_rad, abs=1e-4)
    assert other.control == pytest.approx(as_is.control * [-1, 1], abs=1e-4)


@every_stage
def test_floor_alone_lets_it_drive_straight_on(cls: type[Balance | TimeToContact]) -> None:
    steering = steer(cls, flow(downward(3.0)))
    assert steering.theta_rad == pytest.approx(0.0, abs=1e-6)
    assert steering.repulsive == pytest.approx([0.0, 0.0], abs=1e-6)


@every_stage
@pytest.mark.parametrize("valid", [0, np.arange(COLS) == 3])
def test_without_valid_vectors_there_is_no_force(cls: type[Balance | TimeToContact], valid: npt.ArrayLike) -> None:
    wild = np.random.default_rng(0).normal(0, 50, (ROWS, COLS, 2)).astype(np.float32)
    steering = steer(cls, flow(wild, valid))
    assert not steering.repulsive.any()
    assert steering.theta_rad == 0.0


@every_stage
def test_vectors_that_are_not_valid_do_not_count(cls: type[Balance | TimeToContact]) -> None:
    seen = OBSTACLE_RIGHT[cls]
    valid = (np.random.default_rng(1).random((ROWS, COLS)) < 0.97).astype(np.uint8)
    wild = np.where(valid[..., None] != 0, seen.uv_px, np.float32(1000.0))
    assert steer(cls, flow(wild, valid)).theta_rad == pytest.approx(steer(cls, seen).theta_rad, rel=0.05)


@every_stage
def test_robot_at_rest_is_told_to_drive(cls: type[Balance | TimeToContact]) -> None:
    assert steer(cls, flow(downward(0.0))).theta_rad == 0.0


def test_balance_is_the_difference_of_the_sides_by_their_sum() -> None:
    twice = flow(downward(2.0, slice(COLS // 2, COLS)))
    assert steer(Balance, twice, gain=0.6).repulsive[0] == pytest.approx(-0.6 * (2 - 1) / (2 + 1))
    # More vectors on one side weigh no more than few.
    sparse = np.ones((ROWS, COLS), np.uint8)
    sparse[:100, COLS // 2 :] = 0
    assert steer(Balance, flow(twice.uv_px, sparse), gain=0.6).repulsive[0] == pytest.approx(-0.2)


@pytest.mark.parametrize("rate_per_s", [0.1, 0.5, 2.0])
def test_time_to_contact_is_that_of_a_plane_that_nears(rate_per_s: float) -> None:
    for divergence in BOTH:
        assert inverse_time(flow(expanding(rate_per_s)), ALL, divergence) == pytest.approx(rate_per_s, rel=1e-4)


def test_turning_does_not_expand() -> None:
    rows, cols = np.mgrid[:ROWS, :COLS].astype(np.float32)
    turning = np.stack([0.1 * (rows - 60), -0.1 * (cols - 200)], axis=-1)
    for divergence in BOTH:
        assert inverse_time(flow(turning), ALL, divergence) == pytest.approx(0.0, abs=1e-6)


def test_edge_that_leaves_downwards_expands_along_but_not_across() -> None:
    entering = downward(2.0)
    entering[:60] *= 2
    assert inverse_time(flow(entering[::-1].copy()), ALL, "full") > 0.05
    assert inverse_time(flow(entering[::-1].copy()), ALL, "across") == pytest.approx(0.0, abs=1e-6)
    assert inverse_time(flow(entering), ALL, "full") == 0.0


def test_contact_ahead_brakes_until_it_turns() -> None:
    middle = slice(53, 107)
    assert steer(TimeToContact, flow(expanding(0.5, middle)), brake_s=1.0).control[1] == pytest.approx(0.5, abs=0.05)
    near = steer(TimeToContact, flow(expanding(3.0, middle)), brake_s=1.0)
    assert abs(near.theta_rad) > 1.5


def test_what_shrinks_leaves_all_the_time() -> None:
    assert inverse_time(flow(expanding(-1.0)), ALL, "full") == 0.0


def test_flow_on_a_coarser_grid_says_the_same() -> None:
    fine = expanding(0.8)
    coarse = Flow(
        uv_px=np.ascontiguousarray(fine[4::8, 4::8]),
        valid=np.ones((15, 20), np.uint8),
        interval_us=INTERVAL_US,
        step_px=8,
    )
    assert inverse_time(coarse, ALL, "full") == pytest.approx(0.8, rel=1e-3)
