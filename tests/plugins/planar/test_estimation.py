"""Fits from products of vectors against the plain formulas with fields of residuals."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_planar.estimation.egomotion import fitted_motion
from graphnav_planar.estimation.series import Series
from graphnav_planar.motion import correction

from graphnav.arrays import Doubles

CELLS = 300
ORDERS = np.array([[1.0, 0.0, 1.0, 0.0], [0.0, 1.0, 1.0, 2.0]])
NOISE_PX = 0.1


def plain_weights(left_px: Doubles, counts: Doubles) -> Doubles:
    squares = (left_px.reshape(-1, 2) ** 2).sum(axis=1)
    return np.repeat(counts / (1 + squares / NOISE_PX**2) ** 2, 2)


def seen(seed: int) -> tuple[Doubles, Doubles, Doubles]:
    """Return fields (4, 2n), a flow of the motion (0.03, 0.1) that is wrong for a third, and which vectors count."""
    rng = np.random.default_rng(seed)
    basis = rng.normal(0, 40, (4, 2 * CELLS))
    flow = (np.array([0.03, 0.1, 0.003, 0.01]) @ basis + rng.normal(0, 0.03, 2 * CELLS)).reshape(-1, 2)
    flow[: CELLS // 3] += rng.normal(0, 2, (CELLS // 3, 2))
    return basis, flow.reshape(-1), (rng.random(CELLS) < 0.8).astype(np.float64)


@pytest.mark.parametrize("seed", range(5))
def test_a_correction_is_that_of_reweighted_least_squares(seed: int) -> None:
    basis, flow, counts = seen(seed)
    expected = np.array([0.029, 0.102, 0.029 * 0.102, 0.102**2])
    rates = np.array([[1, 0, 1, 0], [0, 1, 1, 2]]) * expected @ basis
    difference, shares = flow - expected @ basis, np.zeros(2)
    for _ in range(3):
        weighted = rates * plain_weights(difference - shares @ rates, counts)
        shares = np.linalg.solve(weighted @ rates.T + 1e-6 * np.eye(2), weighted @ difference).clip(-0.1, 0.1)
    fields = np.stack([difference, *rates]).astype(np.float32)
    # float32: a relative error of some 1e-6 of shares of some hundredths
    assert correction(fields, counts.astype(np.float32), 0.1) == pytest.approx(shares, abs=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_a_motion_is_that_of_gauss_newton_on_the_residuals(seed: int) -> None:
    basis, flow, counts = seen(seed)
    series = Series(basis, ORDERS)
    start = np.array([0.028, 0.11])
    found = fitted_motion(series, series.products(flow), counts, start, NOISE_PX)
    v, w = start
    for _ in range(4):
        left = flow - np.array([v, w, v * w, w * w]) @ basis
        slopes = np.array([[1, 0, w, 0], [0, 1, v, 2 * w]]) @ basis
        weighted = slopes * plain_weights(left, counts)
        v, w = np.array([v, w]) + np.linalg.solve(weighted @ slopes.T + 1e-3 * np.eye(2), weighted @ left)
    assert found == pytest.approx([v, w], abs=1e-9)
    assert series.flow(found) == pytest.approx(np.array([v, w, v * w, w * w]) @ basis, abs=1e-6)
