"""A refinement agrees with a plain implementation of its formulas, written with loops over windows."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_flow.refinement import Refinement

from graphnav.arrays import Doubles, Floats, Longs
from tests.plugins.flow.conftest import Pattern

ROWS, COLS, WINDOW_PX, E_GRAY2 = 17, 23, 5, 1.0
TOLERANCE_PX = 2e-5
"""Single precision: a relative error of 1e-6 in sums of products of about 100, solved for corrections of about 1."""


def bilinear(image: Doubles, x: Doubles, y: Doubles, beyond: Doubles) -> Doubles:
    """Return samples of ``image``, whose pixels outside are as ``beyond``."""
    rows, cols = image.shape
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)

    def at(row: Longs, col: Longs) -> Doubles:
        is_inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
        values: Doubles = np.where(is_inside, image[np.clip(row, 0, rows - 1), np.clip(col, 0, cols - 1)], beyond)
        return values

    a, b = x - left, y - top
    upper = (1 - a) * at(top, left) + a * at(top, left + 1)
    lower = (1 - a) * at(top + 1, left) + a * at(top + 1, left + 1)
    sampled: Doubles = (1 - b) * upper + b * lower
    return sampled


def derivative(image: Doubles, axis: int) -> Doubles:
    """Return that of the five-point polynomial, on the mirrored image."""
    padded = np.pad(image, 2, mode="reflect")
    at = [np.roll(padded, -shift, axis)[2:-2, 2:-2] for shift in (-2, -1, 1, 2)]
    return (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / 12


def refined(target: Doubles, source: Doubles, f0: Doubles, zoom: int) -> Doubles:
    """Return f, (2, rows, cols)."""
    y, x = np.mgrid[:ROWS, :COLS].astype(float)
    warped = bilinear(source, zoom * (x - f0[0]), zoom * (y - f0[1]), target)
    g = np.stack([derivative((target + warped) / 2, axis) for axis in (1, 0)], axis=-1)
    difference = warped - target
    f, half = f0.copy(), WINDOW_PX // 2
    for row in range(ROWS):
        for col in range(COLS):
            window = np.s_[max(0, row - half) : row + half + 1, max(0, col - half) : col + half + 1]
            gradients = g[window].reshape(-1, 2)
            tensor = gradients.T @ gradients / WINDOW_PX**2 + E_GRAY2 * np.eye(2)
            f[:, row, col] += np.linalg.solve(tensor, gradients.T @ difference[window].ravel() / WINDOW_PX**2)
    return f


def images(zoom: int) -> tuple[Floats, Floats, Floats]:
    """Return a target, a source that moved by about a pixel, and a field near it that leaves the source in places."""
    pattern = Pattern(3, shortest=6.0)
    y, x = np.mgrid[:ROWS, :COLS].astype(float)
    fine_y, fine_x = np.mgrid[: zoom * (ROWS - 1) + 1, : zoom * (COLS - 1) + 1] / zoom
    target = pattern.sample(x, y).astype(np.float32)
    source = pattern.sample(fine_x + 1.1, fine_y - 0.7).astype(np.float32)
    f0 = np.stack([0.9 + 0.02 * x, -0.6 + 0.03 * y]).astype(np.float32)
    return target, source, f0


def refinement(zoom: int) -> Refinement:
    return Refinement(ROWS, COLS, window_px=WINDOW_PX, regularization_gray2=E_GRAY2, zoom=zoom)


@pytest.mark.parametrize("zoom", [1, 2])
def test_a_refinement_follows_its_formulas(zoom: int) -> None:
    target, source, f0 = images(zoom)
    ours = refinement(zoom)
    ours.field[...] = f0
    ours.improve(target, source)
    expected = refined(target.astype(float), source.astype(float), f0.astype(float), zoom)
    assert np.abs(expected - f0).max() > 0.1
    assert np.abs(ours.field - expected).max() < TOLERANCE_PX


def test_a_kept_tensor_is_the_one_of_the_call_before() -> None:
    target, source, f0 = images(1)
    ours = refinement(1)
    results = []
    for keep_tensor in (False, True):
        ours.field[...] = f0
        ours.improve(target, source, keep_tensor=keep_tensor)
        results.append(ours.field.copy())
    assert np.array_equal(results[0], results[1])


def test_a_call_leaves_nothing_behind_for_the_next() -> None:
    target, source, f0 = images(1)
    used, fresh = refinement(1), refinement(1)
    used.field[...] = 3 * f0
    used.improve(source, target)
    for each in (used, fresh):
        each.field[...] = f0
        each.improve(target, source)
    assert np.array_equal(used.field, fresh.field)
