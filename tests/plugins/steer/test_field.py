"""The obstacle potential against an independent convolution."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from graphnav_steer.potential import obstacle_field

SIGMA = 3.0


@pytest.mark.parametrize(("border", "cv2_border"), [("zero", cv2.BORDER_CONSTANT), ("nearest", cv2.BORDER_REPLICATE)])
def test_potential_is_a_gaussian_of_the_map(border: str, cv2_border: int) -> None:
    d = (np.random.default_rng(3).random((21, 34)) < 0.3).astype(np.float64)
    taps = 2 * 15 + 1
    expected = cv2.GaussianBlur(255 * d, (taps, taps), SIGMA, borderType=cv2_border)
    field = obstacle_field(d, SIGMA, border)  # type: ignore[arg-type]
    assert np.allclose(field.potential, expected, atol=1e-3)


@pytest.mark.parametrize("border", ["zero", "nearest"])
def test_gradient_is_that_of_the_potential(border: str) -> None:
    d = np.zeros((40, 50))
    d[12:25, 30:44] = 1
    field = obstacle_field(d, 6.0, border)  # type: ignore[arg-type]
    down, right = (np.gradient(field.potential, axis=axis) for axis in (0, 1))
    inside = (slice(1, -1), slice(1, -1))
    # Central differences of a Gaussian of sigma 6 err by the third derivative / 6, at most 2 % of the largest slope.
    tolerance = 0.02 * np.abs(field.gradient).max()
    assert np.allclose(field.gradient[..., 0][inside], right[inside], atol=tolerance)
    assert np.allclose(field.gradient[..., 1][inside], down[inside], atol=tolerance)


def test_gradient_points_to_the_obstacle() -> None:
    d = np.zeros((30, 40))
    d[5:10, 30:35] = 1
    right, down = obstacle_field(d, 20.0, "zero").gradient[20, 10]
    assert right > 0
    assert down < 0


def test_gaussian_is_normalised() -> None:
    everywhere = np.ones((5, 7))
    assert np.allclose(obstacle_field(everywhere, 9.0, "nearest").potential, 255.0)
    assert np.allclose(obstacle_field(everywhere, 9.0, "nearest").gradient, 0.0, atol=1e-9)
    assert (obstacle_field(everywhere, 9.0, "zero").potential < 255.0).all()
