"""Places on a local map."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import graphnav_lcm
import numpy as np
import pytest
from scipy import ndimage

import graphnav
from graphnav import LocalMap
from graphnav.core.codec import DecodeError, codec_of, decode, encode
from graphnav.core.record import LogWriter

ROWS, COLS, CELL_M = 30, 40, 0.1
FORMER_FINGERPRINT = "38d8677a0fdc87e5"
"""Of local_map_t in the logs of graphnav 0.19."""


def local_map(x_m: float, y_m: float, yaw_rad: float) -> LocalMap:
    """Return a map from (-1, -2) on with an obstacle along its first column, and the rest of its first row unknown."""
    state = np.full((ROWS, COLS), LocalMap.FREE, np.uint8)
    state[0], state[:, 0] = LocalMap.UNKNOWN, LocalMap.OBSTACLE
    return LocalMap(CELL_M, -1.0, -2.0, x_m, y_m, yaw_rad, state)


def random_map(seed: int) -> LocalMap:
    """Return a map with few obstacles in a known part of it."""
    rng = np.random.default_rng(seed)
    state = np.zeros((ROWS, COLS), np.uint8)
    state[5:20, 3:30] = rng.choice([0, 1, 2, 3], (15, 27), p=[0.02, 0.94, 0.03, 0.01])
    return replace(local_map(0.0, 0.0, 0.0), state=state)


def test_the_middle_of_a_cell_is_in_it() -> None:
    map_ = local_map(0.0, 0.0, 0.0)
    rows, cols = (index.ravel() for index in np.indices((ROWS, COLS)))
    for shift_m in (-0.4 * CELL_M, 0.0, 0.4 * CELL_M):
        x_m = np.asarray(-1.0 + cols * CELL_M + shift_m, np.float64)
        y_m = np.asarray(-2.0 + rows * CELL_M - shift_m, np.float64)
        found = map_.cells_of(x_m, y_m)
        assert np.array_equal(found, (rows, cols))


def test_points_off_the_map_are_in_the_nearest_cells() -> None:
    rows, cols = local_map(0.0, 0.0, 0.0).cells_of(np.array([-9.0, 9.0, 0.0]), np.array([0.0, 0.0, 9.0]))
    assert cols.tolist() == [0, COLS - 1, 10]
    assert rows.tolist() == [20, 20, ROWS - 1]


@pytest.mark.parametrize("yaw_rad", [0.0, math.pi / 2, -2.0])
def test_the_robot_s_frame_is_x_forward_and_y_left(yaw_rad: float) -> None:
    map_ = local_map(0.5, -0.6, yaw_rad)
    forward_m, left_m = np.array([[0.3, 0.0, 0.2], [0.1, 0.0, 0.4]]), np.array([[0.0, 0.3, -0.2], [0.2, 0.0, 0.1]])
    # A complex number turns by a product.
    turned = (forward_m + 1j * left_m) * np.exp(1j * yaw_rad) + (0.5 - 0.6j)
    assert np.array_equal(map_.cells_at(forward_m, left_m), map_.cells_of(turned.real, turned.imag))
    # Distances from a straight rim are linear, and interpolated exactly, up to the rounding of float32.
    rim_m = CELL_M / 2
    assert map_.obstacle_m_at(forward_m, left_m) == pytest.approx(turned.real + 1.0 - rim_m, abs=1e-5)
    assert map_.unknown_m_at(forward_m, left_m) == pytest.approx(turned.imag + 2.0 - rim_m, abs=1e-5)


def test_distances_off_the_map_are_those_at_its_rim() -> None:
    map_ = local_map(0.0, 0.0, 0.0)
    (far,) = map_.obstacle_m_at(np.array([50.0]), np.array([0.0]))
    # The last thousandth of a cell is not used.
    assert far == pytest.approx((COLS - 1.5) * CELL_M, abs=0.002 * CELL_M)


@pytest.mark.parametrize("seed", range(4))
def test_distances_are_those_of_another_implementation(seed: int) -> None:
    map_ = random_map(seed)
    for found, there in ((map_.obstacle_m, map_.state >= 2), (map_.unknown_m, map_.state == 0)):
        apart_m = CELL_M * (ndimage.distance_transform_edt(~there) - 0.5)
        assert found == pytest.approx(np.maximum(apart_m, 0.0), abs=1e-5)
        assert not found.flags.writeable


@pytest.mark.parametrize("state", [LocalMap.UNKNOWN, LocalMap.FREE, LocalMap.OBSTACLE])
def test_without_any_such_cell_distances_are_the_size_of_the_map(state: int) -> None:
    map_ = replace(local_map(0.0, 0.0, 0.0), state=np.full((ROWS, COLS), state, np.uint8))
    across_m = pytest.approx(CELL_M * math.hypot(ROWS, COLS), abs=CELL_M)
    assert map_.obstacle_m.max() == (0.0 if state == LocalMap.OBSTACLE else across_m)
    assert map_.unknown_m.max() == (0.0 if state == LocalMap.UNKNOWN else across_m)


def test_distances_are_computed_once_for_all_who_get_the_map() -> None:
    one = decode(LocalMap, encode(random_map(0), 1, 2))[2]
    other, coarse = one.twin(), replace(one, cell_m=2 * CELL_M)
    assert other.obstacle_m is one.obstacle_m
    assert other.unknown_m is one.unknown_m
    assert coarse.obstacle_m == pytest.approx(2 * one.obstacle_m, abs=1e-5)
    assert replace(one, state=one.state.copy()).obstacle_m is not one.obstacle_m


def test_it_survives_the_bus() -> None:
    map_ = local_map(0.5, -0.6, 0.4)
    back = decode(LocalMap, encode(map_, 1, 2))[2]
    assert (back.cell_m, back.origin_x_m, back.origin_y_m) == (CELL_M, -1.0, -2.0)
    assert (back.x_m, back.y_m, back.yaw_rad) == (0.5, -0.6, 0.4)
    for name in ("state", "obstacle_m", "unknown_m"):
        assert np.array_equal(getattr(back, name), getattr(map_, name))


def test_a_log_with_the_former_type_is_read(tmp_path: Path) -> None:
    map_ = random_map(1)
    fields = {**map_.lcm_fields(), "obstacle_m": map_.obstacle_m, "unknown_m": map_.unknown_m}
    data = codec_of(graphnav_lcm.local_map_t).encode({**fields, "utime": 5, "seq": 1})
    assert data[:8].hex() == FORMER_FINGERPRINT
    with LogWriter(tmp_path / "old.lcmlog") as log:
        log.write("local.local_map", 5, data)
    with graphnav.open_log(tmp_path / "old.lcmlog") as found:
        assert found.channels["local.local_map"].message is LocalMap
        (back,) = (sample.message for sample in found.messages("local.local_map"))
    assert (back.cell_m, back.x_m, back.yaw_rad) == (map_.cell_m, map_.x_m, map_.yaw_rad)
    for name in ("state", "obstacle_m", "unknown_m"):
        assert np.array_equal(getattr(back, name), getattr(map_, name))


def test_a_damaged_message_of_the_former_type_is_refused() -> None:
    with pytest.raises(DecodeError, match=r"a damaged graphnav_lcm\.local_map_t of 28 bytes"):
        decode(LocalMap, bytes.fromhex(FORMER_FINGERPRINT) + bytes(20))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"state": np.zeros((0, 0), np.uint8)}, "rows is 0, expected 2 to 4096"),
        ({"state": np.zeros((1, 9), np.uint8)}, "rows is 1, expected 2 to 4096"),
        ({"state": np.full((ROWS, COLS), 4, np.uint8)}, "the largest state is 4, expected 0 to 3"),
        ({"cell_m": 0.0}, "cell_m is 0, expected 0.0001 to 1000"),
        ({"cell_m": -0.1}, "cell_m is -0.1, expected 0.0001 to 1000"),
        ({"x_m": 9.0}, "x_m - origin_x_m is 10, expected -0.1 to "),
        ({"y_m": 1e308, "origin_y_m": -1e308}, "y_m - origin_y_m is inf, expected -0.1 to "),
    ],
)
def test_a_map_that_no_robot_can_be_on_is_refused(wrong: dict[str, Any], said: str) -> None:
    map_ = replace(local_map(0.5, -0.6, 0.4), **wrong)
    data = encode(map_, 1, 2)
    with pytest.raises(DecodeError, match=said):
        decode(LocalMap, data)
