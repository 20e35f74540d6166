"""Values of a scan: directions, hits, free ways, points; and scans that no lidar measures."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from graphnav import Scan
from graphnav.core.codec import DecodeError, decode, encode

RANGES = np.array([1.0, 2.0, math.inf, math.nan, 0.05, 9.0], np.float32)
SCAN = Scan(angle_min_rad=-1.0, angle_increment_rad=0.5, range_min_m=0.1, range_max_m=5.0, ranges_m=RANGES)


def test_beams_are_spread_counterclockwise() -> None:
    assert SCAN.angles_rad().tolist() == [-1.0, -0.5, 0.0, 0.5, 1.0, 1.5]


def test_only_distances_that_are_measured_are_hits() -> None:
    assert SCAN.hits().tolist() == [True, True, False, False, False, False]


def test_a_beam_without_echo_passes_and_one_that_tells_nothing_does_not() -> None:
    assert SCAN.free_m().tolist() == [1.0, 2.0, 5.0, 0.0, 0.0, 0.0]


def test_points_are_forward_and_left() -> None:
    ahead = replace(SCAN, angle_min_rad=0.0, angle_increment_rad=math.pi / 2, ranges_m=np.array([1, 2, 3], np.float32))
    assert ahead.points_m() == pytest.approx(np.array([[1.0, 0.0], [0.0, 2.0], [-3.0, 0.0]]))


def test_it_is_read_as_it_was_sent() -> None:
    utime, found = decode(Scan, encode(SCAN, 7, 1))[::2]
    assert utime == 7
    assert np.array_equal(found.ranges_m, RANGES, equal_nan=True)
    assert (found.angle_min_rad, found.range_max_m) == (-1.0, 5.0)


@pytest.mark.parametrize(
    ("field", "value", "told"),
    [
        ("ranges_m", np.zeros(0, np.float32), "n_beams is 0, expected 1 to 100000"),
        ("angle_increment_rad", 0.0, "angle_increment_rad is 0, expected beams once around, not more"),
        ("angle_increment_rad", -2.0, "angle_increment_rad is -2, expected beams once around, not more"),
        ("range_min_m", -0.1, "range_min_m is -0.1, expected 0 or more"),
        ("range_max_m", 0.1, "range_max_m is 0.1, expected more than range_min_m"),
    ],
)
def test_a_scan_that_no_lidar_measures_is_refused(field: str, value: Any, told: str) -> None:
    with pytest.raises(DecodeError, match=told):
        decode(Scan, encode(replace(SCAN, **{field: value}), 0, 0))
