"""Metrics of a drive, worked by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pytest
from graphnav_score.navigation import MeanJerk, Navigation, spl

from graphnav import Latest, Map, Stamp, State


class At(NamedTuple):
    """A state in short."""

    x_m: float
    y_m: float = 0.0
    clearance_m: float = 1.0
    contact: bool = False
    at_goal: bool = False


def map_of(shortest_m: float, *, goal: bool = True) -> Map:
    return Map(
        kind=np.zeros(0, np.uint8),
        height_m=np.zeros(0),
        vertices_m=np.zeros((0, 2)),
        body=np.zeros(0, np.int32),
        start=np.zeros(3),
        goal_m=np.zeros((4 if goal else 0, 2)),
        robot_radius_m=0.2,
        shortest_m=shortest_m,
        footprint_m=np.zeros((0, 2)),
    )


def drive(
    states: Sequence[At], world: Map | None, period_s: float = 1.0, speed_mps: float | None = 0.5
) -> Mapping[str, float]:
    stage = Navigation(optimal_speed_mps=speed_mps)
    stage.reset(seed=0)
    for k, at in enumerate(states):
        state = State(
            x_m=at.x_m,
            y_m=at.y_m,
            yaw_rad=0.0,
            v_mps=1.0,
            omega_radps=0.0,
            clearance_m=at.clearance_m,
            contact=at.contact,
            at_goal=at.at_goal,
            moving=np.zeros((0, 3)),
        )
        sampled = Latest(world, 0.0) if world is not None and k == 0 else Latest[Map]()
        stage.step(state, sampled, Stamp(round(k * period_s * 1e6)))
    return stage.summary()


def test_success() -> None:
    states = [At(0), At(3, clearance_m=0.4), At(3, 4, clearance_m=0.6), At(3, 5, at_goal=True)]
    metrics = drive(states, map_of(6.0), period_s=10.0)
    assert (metrics["success"], metrics["collision"], metrics["timeout"]) == (1.0, 0.0, 0.0)
    assert metrics["min_clearance_m"] == 0.4
    assert metrics["mean_clearance_m"] == pytest.approx(0.75)
    assert metrics["path_length_m"] == pytest.approx(8.0)
    assert metrics["duration_s"] == pytest.approx(30.0)
    assert metrics["spl"] == pytest.approx(6 / 8)
    assert metrics["sct"] == pytest.approx(12 / 30), "6 m at 0.5 m/s take 12 s"
    assert metrics["mean_jerk_mps3"] == 0.0


@pytest.mark.parametrize(
    ("legs_m", "shortest_m", "seconds", "spl_", "sct_"),
    [
        # Around three sides of a square of 2 m where the shortest way is the fourth.
        ([2.0, 2.0, 2.0], 2.0, 10.0, 2 / 6, 4 / 10),
        # The optimal time of 2 m at 0.5 m/s is 4 s.
        ([2.0], 2.0, 3.0, 1.0, 1.0),
        ([2.0], 2.0, 8.0, 1.0, 0.5),
        ([2.0], 2.0, 100.0, 1.0, 1 / 25),
        # The goal is a region: a way may be shorter than the one that was planned to it.
        ([1.9], 2.0, 16.0, 1.0, 1 / 4),
    ],
)
def test_scores_of_complete_drives(
    legs_m: list[float], shortest_m: float, seconds: float, spl_: float, sct_: float
) -> None:
    corners, directions = [At(0.0, 0.0)], [(1, 0), (0, 1), (-1, 0)]
    for length_m, (x, y) in zip(legs_m, directions, strict=False):
        corners.append(At(corners[-1].x_m + x * length_m, corners[-1].y_m + y * length_m))
    corners[-1] = corners[-1]._replace(at_goal=True)
    metrics = drive(corners, map_of(shortest_m), period_s=seconds / len(legs_m))
    assert metrics["spl"] == pytest.approx(spl_)
    assert metrics["sct"] == pytest.approx(sct_)
    touched = [*corners[:-1], corners[-1]._replace(contact=True)]
    metrics = drive(touched, map_of(shortest_m), period_s=seconds / len(legs_m))
    assert metrics["spl"] == metrics["sct"] == 0.0


def test_contact_is_no_success_and_no_timeout() -> None:
    metrics = drive([At(0), At(1, contact=True, clearance_m=0.0)], map_of(6.0))
    assert (metrics["success"], metrics["collision"], metrics["timeout"]) == (0.0, 1.0, 0.0)
    assert metrics["spl"] == metrics["sct"] == metrics["min_clearance_m"] == 0.0


def test_neither_goal_nor_contact_is_a_timeout() -> None:
    metrics = drive([At(0), At(1)], map_of(6.0))
    assert (metrics["success"], metrics["collision"], metrics["timeout"]) == (0.0, 0.0, 1.0)


def test_without_a_goal_there_is_no_success() -> None:
    metrics = drive([At(0), At(1)], map_of(0.0, goal=False))
    assert metrics["collision"] == 0.0
    assert not {"success", "timeout", "spl", "sct"} & metrics.keys()


def test_without_the_map_there_is_no_shortest_path() -> None:
    metrics = drive([At(0), At(1, at_goal=True)], None)
    assert metrics["success"] == 1.0
    assert not {"spl", "sct"} & metrics.keys()


def test_before_the_first_state_there_are_no_metrics() -> None:
    assert drive([], map_of(6.0)) == {}


def test_every_figure_is_a_finite_float() -> None:
    for states in ([At(0)], [At(0, at_goal=True)], [At(0), At(0)]):
        metrics = drive(states, map_of(0.0))
        assert all(type(value) is float and math.isfinite(value) for value in metrics.values())


@pytest.mark.parametrize(
    ("shortest_m", "path_m", "expected"), [(4.0, 8.0, 0.5), (4.0, 4.0, 1.0), (4.0, 3.9, 1.0), (0.0, 0.0, 1.0)]
)
def test_spl(shortest_m: float, path_m: float, expected: float) -> None:
    assert spl(shortest_m, path_m) == pytest.approx(expected)


@pytest.mark.parametrize(("speed_mps", "expected"), [(None, 4.0 / 10.0), (0.5, 8.0 / 10.0), (2.0, 2.0 / 10.0)])
def test_the_optimal_time_is_that_of_the_robots_own_speed_unless_one_is_given(
    speed_mps: float | None, expected: float
) -> None:
    states = [At(0), At(2), At(4, at_goal=True)]  # the states' speed is 1 m/s
    assert drive(states, map_of(4.0), period_s=5.0, speed_mps=speed_mps)["sct"] == pytest.approx(expected)


def test_jerk_of_a_velocity_that_grows_quadratically_is_constant() -> None:
    jerk = MeanJerk()
    for k in range(20):
        t_s = 0.1 * k
        jerk.add((0.5 * 3.0 * t_s**2, 0.5 * 4.0 * t_s**2), t_s)
    assert jerk.mean_mps3 == pytest.approx(5.0)


def test_jerk_needs_three_velocities() -> None:
    jerk = MeanJerk()
    for k in range(2):
        jerk.add((0.0, 0.0), float(k))
        assert jerk.mean_mps3 is None


def test_what_is_near_the_start_is_not_the_minimum_clearance() -> None:
    states = [At(0, clearance_m=0.1), At(0.9, clearance_m=0.2), At(1.0, clearance_m=0.5), At(2.0, clearance_m=0.4)]
    assert drive(states, None)["min_clearance_m"] == 0.4
    assert drive(states, None)["mean_clearance_m"] == pytest.approx(0.3)


def test_a_drive_of_less_than_a_metre_has_a_minimum_clearance_only_if_it_touched_something() -> None:
    states = [At(0, clearance_m=0.35), At(0.5, clearance_m=0.3)]
    assert "min_clearance_m" not in drive(states, None)
    assert drive([*states, At(0.8, clearance_m=0.0, contact=True)], None)["min_clearance_m"] == 0.0


def test_where_nothing_is_near_no_clearance_is_claimed() -> None:
    metrics = drive([At(0, clearance_m=1000.0), At(1, clearance_m=1000.0)], None)
    assert not {"min_clearance_m", "mean_clearance_m"} & set(metrics)
