"""The principal direction of gradients against numpy's eigenvectors."""

from __future__ import annotations

import numpy as np
import pytest
from graphnav_steer.principal import principal_direction


def elongated(seed: int, mean: tuple[float, float]) -> np.ndarray:
    rng = np.random.default_rng(seed)
    gradient: np.ndarray = rng.standard_normal((30, 40, 2)) @ np.array([[3.0, 1.0], [0.0, 1.0]]) + np.array(mean)
    return gradient


@pytest.mark.parametrize("seed", range(5))
def test_direction_is_the_first_eigenvector_of_the_covariance(seed: int) -> None:
    gradient = elongated(seed, (1.0, 0.5))
    found = principal_direction(gradient, "centroid", 1.1)
    values, vectors = np.linalg.eigh(np.cov(gradient.reshape(-1, 2).T, bias=True))
    assert found.direction is not None
    assert abs(found.direction @ vectors[:, 1]) == pytest.approx(1.0)
    assert np.allclose(found.eigenvalues, values[::-1])


def test_direction_agrees_with_the_mean_gradient() -> None:
    for mean in ((1.0, 0.5), (-1.0, -0.5)):
        gradient = elongated(0, mean)
        found = principal_direction(gradient, "zero", 1.1)
        assert found.direction is not None
        assert found.direction @ gradient.mean(axis=(0, 1)) > 0


def test_about_zero_the_mean_itself_counts() -> None:
    gradient = np.random.default_rng(1).standard_normal((30, 40, 2)) * np.array([1.0, 3.0]) + np.array([20.0, 0.0])
    about_zero = principal_direction(gradient, "zero", 1.1).direction
    assert about_zero is not None
    assert about_zero[0] == pytest.approx(1.0, abs=0.01)
    about_centroid = principal_direction(gradient, "centroid", 1.1).direction
    assert about_centroid is not None
    assert abs(about_centroid[0]) < 0.2


def test_isotropic_gradients_fall_back_on_their_mean() -> None:
    gradient = np.random.default_rng(2).standard_normal((30, 40, 2)) + np.array([0.3, 0.4])
    found = principal_direction(gradient, "centroid", 1.5)
    mean = gradient.mean(axis=(0, 1))
    assert found.direction is not None
    assert np.allclose(found.direction, mean / np.hypot(*mean))


def test_mean_across_the_principal_direction_takes_its_place() -> None:
    gradient = np.array([[5.0, 1.0], [-5.0, 1.0]])
    found = principal_direction(gradient, "centroid", 1.1)
    assert found.direction is not None
    assert np.allclose(found.direction, [0.0, 1.0])


@pytest.mark.parametrize("gradient", [np.zeros((4, 2)), np.array([[1.0, 2.0], [-1.0, -2.0]]), np.zeros((1, 1, 2))])
def test_without_a_mean_there_is_no_direction(gradient: np.ndarray) -> None:
    found = principal_direction(gradient, "zero", 1.1)
    assert found.direction is None
    assert np.isfinite(found.eigenvalues).all()
