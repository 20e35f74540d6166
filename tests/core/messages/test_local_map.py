"""Places on a local map."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from graphnav import LocalMap
from graphnav.core.codec import DecodeError, decode, encode

ROWS, COLS, CELL_M = 30, 40, 0.1


def local_map(x_m: float, y_m: float, yaw_rad: float) -> LocalMap:
    """Return a map from (-1, -2) on whose distances are linear in x and y."""
    x, y = np.meshgrid(-1.0 + CELL_M * np.arange(COLS), -2.0 + CELL_M * np.arange(ROWS))
    state = (np.arange(ROWS * COLS, dtype=np.uint8) % 3).reshape(ROWS, COLS)
    linear = [(5 + x - 2 * y).astype(np.float32), (7 - x + y).astype(np.float32)]
    return LocalMap(CELL_M, -1.0, -2.0, x_m, y_m, yaw_rad, state, *linear)


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
    # What is linear is interpolated exactly, up to the rounding of float32.
    expected = 5 + turned.real - 2 * turned.imag
    assert map_.obstacle_m_at(forward_m, left_m) == pytest.approx(expected, abs=1e-5)
    assert map_.unknown_m_at(forward_m, left_m) == pytest.approx(7 - turned.real + turned.imag, abs=1e-5)


def test_distances_off_the_map_are_those_at_its_rim() -> None:
    map_ = local_map(0.0, 0.0, 0.0)
    (far,) = map_.obstacle_m_at(np.array([50.0]), np.array([0.0]))
    # The last thousandth of a cell is not used.
    assert far == pytest.approx(5 + 2.9, abs=0.002 * CELL_M)


def test_it_survives_the_bus() -> None:
    map_ = local_map(0.5, -0.6, 0.4)
    back = decode(LocalMap, encode(map_, 1, 2))[2]
    assert (back.cell_m, back.origin_x_m, back.origin_y_m) == (CELL_M, -1.0, -2.0)
    assert (back.x_m, back.y_m, back.yaw_rad) == (0.5, -0.6, 0.4)
    for name in ("state", "obstacle_m", "unknown_m"):
        assert np.array_equal(getattr(back, name), getattr(map_, name))


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
        ({"unknown_m": np.full((ROWS, COLS), -1, np.float32)}, "unknown_m is -1 to -1, expected 0 to 1e\\+06"),
        (
            {"obstacle_m": np.full((ROWS, COLS), 3e38, np.float32)},
            "obstacle_m is 3e\\+38 to 3e\\+38, expected 0 to 1e\\+06",
        ),
    ],
)
def test_a_map_that_no_robot_can_be_on_is_refused(wrong: dict[str, Any], said: str) -> None:
    map_ = replace(local_map(0.5, -0.6, 0.4), **wrong)
    if "state" in wrong:
        far = np.ones(wrong["state"].shape, np.float32)
        map_ = replace(map_, obstacle_m=far, unknown_m=far)
    data = encode(map_, 1, 2)
    with pytest.raises(DecodeError, match=said):
        decode(LocalMap, data)
