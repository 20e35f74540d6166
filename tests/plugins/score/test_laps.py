"""Laps of drives whose places are given."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from graphnav_score.laps import Laps

from graphnav import Latest, Map, Stamp, State

SQUARE = np.array([[-4.0, -2.0], [6.0, -2.0], [6.0, 4.0], [-4.0, 4.0]])
MIDDLE = (1.0, 1.0)
WORLD = Map(
    kind=np.zeros(1, np.uint8),
    height_m=np.ones(1),
    vertices_m=SQUARE,
    body=np.zeros(4, np.int32),
    start=np.zeros(3),
    goal_m=np.zeros((0, 2)),
    robot_radius_m=0.2,
    shortest_m=0.0,
    footprint_m=np.zeros((0, 2)),
)


def box(half_m: float) -> np.ndarray:
    """Return a square about the middle, (4, 2)."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    return np.asarray(corners * half_m + np.array(MIDDLE))


RING = replace(
    WORLD,
    kind=np.zeros(4, np.uint8),
    height_m=np.ones(4),
    vertices_m=np.concatenate([box(1.9), box(2.0), box(4.0), box(4.1)]),
    body=np.repeat(np.arange(4, dtype=np.int32), 4),
)
"""A corridor between two squares, whose walls are 0.1 m thick: its centreline is a square of 6 m."""


def around(
    laps: float, seconds: int = 60, *, contact: bool = False, min_laps: float = 1.0, world: Map = WORLD
) -> Mapping[str, float]:
    """Return the metrics of a drive around the middle, counterclockwise, a state a second."""
    stage = Laps(duration_s=60, min_laps=min_laps)
    stage.reset(seed=0)
    for k in range(seconds + 1):
        angle = 2 * math.pi * laps * k / seconds
        state = State(
            x_m=MIDDLE[0] + 3 * math.cos(angle),
            y_m=MIDDLE[1] + 3 * math.sin(angle),
            yaw_rad=0.0,
            v_mps=0.3,
            omega_radps=0.0,
            clearance_m=0.4,
            contact=contact and k == seconds,
            at_goal=False,
            moving=np.zeros((int((world.kind == Map.MOVING).sum()), 3)),
        )
        stage.step(state, Latest(world, 0.0), Stamp(k * 1_000_000))
    return stage.summary()


@pytest.mark.parametrize("laps", [0.25, 2.5, -1.75])
def test_laps_are_turns_about_the_middle_to_either_side(laps: float) -> None:
    assert around(laps)["laps"] == pytest.approx(abs(laps))


@pytest.mark.parametrize("laps", [1.0, 2.5, -1.75])
def test_progress_is_along_the_centreline(laps: float) -> None:
    metrics = around(laps, world=RING)
    assert metrics["progress_m"] == pytest.approx(24.0 * abs(laps))
    assert metrics["progress_ratio"] == pytest.approx(24.0 * abs(laps) / (0.3 * 60))


def test_progress_through_a_part_of_a_side_is_the_way_along_it() -> None:
    # From bearing 0 to atan(1/2): the side at x = 3 from the middle, 1.5 m along it. A chord between two of the
    # centreline's points, a degree apart, is on that side.
    share = math.atan(0.5) / (2 * math.pi)
    assert around(share, world=RING)["progress_m"] == pytest.approx(1.5, abs=1e-3)


def test_what_is_driven_back_is_not_progress() -> None:
    there, back = around(1.0, world=RING), around(0.0, world=RING)
    assert there["progress_m"] > back["progress_m"] == pytest.approx(0.0)


def test_without_a_corridor_there_is_no_progress() -> None:
    assert around(1.0).keys().isdisjoint({"progress_m", "progress_ratio"})


def test_a_success_lasts_goes_round_and_touches_nothing() -> None:
    assert around(1.5)["success"] == 1.0
    assert around(1.5, seconds=59)["success"] == 0.0
    assert around(0.9)["success"] == 0.0
    assert around(1.5, min_laps=2)["success"] == 0.0
    assert around(1.5, contact=True)["success"] == 0.0


def test_what_a_drive_to_a_goal_has_is_left_out() -> None:
    values = around(1.5)
    assert values.keys() <= {metric.name for metric in Laps.metrics}
    assert {"min_clearance_m", "path_length_m", "collision"} <= values.keys()
    assert not {"spl", "timeout"} & values.keys()


def test_nothing_is_reported_before_the_first_state() -> None:
    stage = Laps()
    stage.reset(seed=0)
    assert stage.summary() == {}


def test_the_middle_is_that_of_what_stands() -> None:
    far = np.array([[-60.0, 0.0], [-50.0, 0.0], [-50.0, 1.0]])  # of a mover, in its own frame
    moving = replace(
        WORLD,
        kind=np.array([0, Map.MOVING], np.uint8),
        height_m=np.ones(2),
        vertices_m=np.concatenate([SQUARE, far]),
        body=np.array([0, 0, 0, 0, 1, 1, 1], np.int32),
    )
    assert around(2.5, world=moving)["laps"] == pytest.approx(2.5)
    only_moving = replace(moving, kind=np.full(2, Map.MOVING, np.uint8))
    assert around(2.5, world=only_moving)["laps"] == 0.0
