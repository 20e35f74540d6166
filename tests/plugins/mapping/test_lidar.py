"""The map of scans that are made by hand: what is marked, freed, remembered and unknown."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from graphnav_mapping.lidar import Lidar

from graphnav import LocalMap, Motion, ParamError, Scan, Stamp
from graphnav.arrays import Doubles

BEAMS = 541
STEP_RAD = 1.5 * math.pi / (BEAMS - 1)


def scan(ranges_m: Doubles | float) -> Scan:
    ranges = np.broadcast_to(np.asarray(ranges_m, np.float32), (BEAMS,))
    return Scan(-0.75 * math.pi, STEP_RAD, 0.1, 10.0, ranges)


def wall_ahead(at_m: float) -> Scan:
    """Return the scan of an endless wall across the way."""
    angles = -0.75 * math.pi + STEP_RAD * np.arange(BEAMS)
    ahead = np.cos(angles) > 0.05
    return scan(np.where(ahead, at_m / np.where(ahead, np.cos(angles), 1.0), math.inf))


class Feed:
    """A stage that is fed with scans, ten a second."""

    def __init__(self, **parameters: Any) -> None:
        self.stage = Lidar(**({"size_m": 6.05, "robot_radius_m": 0.2} | parameters))
        self.stage.reset(seed=0)
        self.utime = 0

    def see(self, scan: Scan, forward_m: float = 0.0, turn_rad: float = 0.0) -> LocalMap:
        self.utime += 100_000
        motion = Motion(forward_m=forward_m, left_m=0.0, turn_rad=turn_rad, interval_us=100_000)
        return self.stage.step(scan, motion, Stamp(self.utime))


def state(map: LocalMap, forward_m: float, left_m: float = 0.0) -> int:  # noqa: A002
    (row,), (col,) = map.cells_at(np.array([forward_m]), np.array([left_m]))
    return int(map.state[row, col])


def test_what_is_hit_is_an_obstacle_before_it_is_free_behind_unknown() -> None:
    found = Feed().see(wall_ahead(1.0))
    assert [state(found, 1.0, left) for left in (-1.0, 0.0, 1.0)] == [LocalMap.OBSTACLE] * 3
    assert [state(found, 0.9, left) for left in (-1.0, 0.0, 1.0)] == [LocalMap.FREE] * 3
    assert [state(found, 1.1, left) for left in (-1.0, 0.0, 1.0)] == [LocalMap.UNKNOWN] * 3


@pytest.mark.parametrize("yaw_rad", [0.0, 1.1, -2.0])
def test_the_map_does_not_turn_with_the_robot(yaw_rad: float) -> None:
    feed = Feed()
    feed.see(scan(math.nan))
    found = feed.see(wall_ahead(1.0), turn_rad=yaw_rad)
    assert found.yaw_rad == pytest.approx(yaw_rad)
    assert state(found, 1.0) == LocalMap.OBSTACLE
    assert state(found, 0.8) == LocalMap.FREE
    assert found.obstacle_m_at(np.zeros(1), np.zeros(1))[0] == pytest.approx(1.0, abs=0.06)


def test_behind_the_field_of_view_only_the_floor_below_the_robot_is_free() -> None:
    found = Feed().see(scan(math.inf))
    assert state(found, -0.15) == LocalMap.FREE
    assert state(found, -0.4) == LocalMap.UNKNOWN
    assert state(found, 0.4) == LocalMap.FREE


def test_it_marks_and_frees_within_its_distances() -> None:
    feed = Feed(mark_m=1.5, clear_m=2.0)
    assert state(feed.see(wall_ahead(1.8)), 1.8) == LocalMap.UNKNOWN
    found = feed.see(scan(math.inf))
    assert (state(found, 1.9), state(found, 2.1)) == (LocalMap.FREE, LocalMap.UNKNOWN)


def test_what_was_seen_stays_until_it_is_seen_otherwise() -> None:
    feed = Feed()
    feed.see(wall_ahead(1.0))
    found = feed.see(scan(math.nan), forward_m=0.5)
    assert state(found, 0.5) == LocalMap.OBSTACLE
    assert state(feed.see(scan(math.inf)), 0.5) == LocalMap.FREE


def test_a_beam_between_others_that_tell_nothing_frees_its_own_cells_alone() -> None:
    ranges = np.full(BEAMS, math.nan)
    ranges[BEAMS // 2] = math.inf
    found = Feed(robot_radius_m=0.05).see(scan(ranges))
    assert state(found, 1.0) == LocalMap.FREE
    assert np.count_nonzero(found.state == LocalMap.FREE) < 80


def test_beams_in_clockwise_order_are_the_same() -> None:
    one = wall_ahead(1.0)
    ranges = one.ranges_m.copy()
    ranges[:200] = math.inf
    mirrored = Scan(-one.angle_min_rad, -STEP_RAD, 0.1, 10.0, ranges)
    plain = Scan(one.angle_min_rad, STEP_RAD, 0.1, 10.0, ranges[::-1])
    # Cells midway between two beams may go to either.
    assert np.mean(Feed().see(mirrored).state != Feed().see(plain).state) < 2e-3


def test_a_grid_of_absurd_size_is_an_error() -> None:
    with pytest.raises(ParamError, match=r"'size_m' 100 and 'cell_m' 0.01 give a map of 10000 cells to a side"):
        Lidar(size_m=100.0, cell_m=0.01).check()
