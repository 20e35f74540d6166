"""The fits of `plane.affine` agree with plain implementations of the same estimates."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_plane.affine import Affine, least_squares

from graphnav import Flow, Stamp, coarsen

NOISE_PX = 0.1
ROWS, COLS = 12, 17


def _places(rows: int, cols: int) -> np.ndarray:
    return np.array(
        [((2 * x - cols + 1) / cols, (2 * y - rows + 1) / rows, 1.0) for y in range(rows) for x in range(cols)]
    )


@pytest.mark.parametrize("share", [0.1, 0.5, 1.0])
def test_least_squares_is_numpys(share: float) -> None:
    rng = np.random.default_rng(3)
    near, uv = rng.random((ROWS, COLS)) < share, rng.normal(size=(ROWS * COLS, 2))
    uv[~near.ravel()] = np.nan
    expected = np.linalg.lstsq(_places(ROWS, COLS)[near.ravel()], uv[near.ravel()], rcond=None)[0]
    # The ridge is a billionth of the mean square of a coordinate.
    np.testing.assert_allclose(least_squares(uv, near), expected, atol=1e-7)


def test_least_squares_of_places_on_a_line_continues_what_is_on_it() -> None:
    near = np.zeros((ROWS, COLS), bool)
    near[4] = True
    fit = least_squares(np.full((ROWS * COLS, 2), 2.0), near)
    np.testing.assert_allclose((_places(ROWS, COLS) @ fit)[near.ravel()], 2.0, atol=1e-6)


def _textbook_residual(flow: Flow, seed: int, draws: int, noise_px: float) -> np.ndarray:
    """Return what a fit leaves by least median of squares, drawn as the stage draws, and two refits."""
    judged = flow.valid.ravel() != 0
    places, uv = _places(*flow.valid.shape)[judged], flow.uv_px.reshape(-1, 2)[judged].astype(np.float64)
    every = max(1, len(uv) // 200)
    best, smallest = np.zeros((3, 2)), np.inf
    for three in np.random.default_rng(seed).integers(0, len(uv), (3, draws)).T:
        if abs(np.linalg.det(places[three])) < 1e-3:
            continue
        fit = np.linalg.solve(places[three], uv[three])
        squares = np.sort(((uv - places @ fit)[::every] ** 2).sum(axis=1))
        if squares[len(squares) // 2] < smallest:
            best, smallest = fit, squares[len(squares) // 2]
    for _ in range(2):
        left = np.linalg.norm(uv - places @ best, axis=1)
        near = left <= 2.5 * max(1.4826 * np.sort(left)[len(left) // 2], noise_px / 2.5)
        best = np.linalg.lstsq(places[near], uv[near], rcond=None)[0]
    left_px = flow.uv_px - (_places(*flow.valid.shape) @ best).reshape(flow.uv_px.shape)
    return np.asarray(np.linalg.norm(left_px, axis=-1))


@pytest.mark.parametrize("seed", range(4))
def test_the_score_is_that_of_the_textbook(seed: int) -> None:
    rng = np.random.default_rng(seed)
    motion = rng.normal(size=(3, 2))
    uv = (_places(4 * ROWS, 4 * COLS) @ motion).reshape(4 * ROWS, 4 * COLS, 2) + rng.normal(
        size=(4 * ROWS, 4 * COLS, 2)
    )
    uv[:20, :30] += 4.0
    valid = (rng.random((4 * ROWS, 4 * COLS)) < 0.7).astype(np.uint8)
    flow = Flow(uv_px=uv.astype(np.float32), valid=valid, interval_us=100_000)
    stage = Affine(threshold_px=NOISE_PX, memory_ratio=0.0)
    stage.reset(seed)
    plane = stage.step(flow, Stamp(0))
    cells = coarsen(flow, stage.cell_px)
    expected = _textbook_residual(cells, seed, stage.draws, NOISE_PX)
    # Scores are float32, and so are the residuals that choose the draw.
    np.testing.assert_allclose(plane.score, np.where(cells.valid, expected, 0.0), atol=1e-5)
