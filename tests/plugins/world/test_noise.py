"""Image noise: normal, and drawn from the same bits at every size."""

from __future__ import annotations

from statistics import NormalDist

import numpy as np
import pytest
from graphnav_world.rendering.film import NOISE_STEPS, normal_noise


def test_it_is_normal() -> None:
    noise = normal_noise((400, 400), np.random.default_rng(0))
    assert noise.dtype == np.float32
    assert noise.mean() == pytest.approx(0.0, abs=0.01)
    assert noise.std() == pytest.approx(1.0, abs=0.01)
    assert (np.abs(noise) < 1.0).mean() == pytest.approx(0.6827, abs=0.005)
    assert np.abs(noise).max() < 3.7


@pytest.mark.parametrize("shape", [(12, 16), (9, 9), (9, 10), (11, 3)])
def test_it_draws_one_quantile_for_each_pixel(shape: tuple[int, int]) -> None:
    quantiles = np.array([NormalDist().inv_cdf((k + 0.5) / NOISE_STEPS) for k in range(NOISE_STEPS)], np.float32)
    ours, theirs = np.random.default_rng(5), np.random.default_rng(5)
    for _ in range(3):
        draws = theirs.integers(0, NOISE_STEPS, size=shape, dtype=np.uint16)
        assert np.array_equal(normal_noise(shape, ours), quantiles[draws])
