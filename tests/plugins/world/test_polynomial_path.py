"""Where an obstacle on a polynomial is, against sums over a fine polyline of the same polynomial."""

from __future__ import annotations

import math

import numpy as np
import pytest
from graphnav_world.geometry.polynomial_path import TURN_M, PolynomialPath
from numpy.polynomial import chebyshev

from graphnav.arrays import Doubles


def polynomial(order: int, seed: int) -> Doubles:
    """Return a series whose x is linear and whose y is a polynomial of this order."""
    series = np.zeros((order + 1, 2))
    series[:2, 0] = -2.0, 2.25
    series[:, 1] = np.random.default_rng(seed).normal(size=order + 1)
    return series


def places(path: PolynomialPath, times_s: Doubles) -> Doubles:
    return np.array([path.at(float(time_s)) for time_s in times_s])


ORDERS = [1, 2, 3, 4, 5, 6]


@pytest.mark.parametrize("order", ORDERS)
def test_between_its_turns_it_is_as_far_along_the_polynomial_as_its_speed_says(order: int) -> None:
    series = polynomial(order, order)
    line = chebyshev.chebval(np.linspace(-1, 1, 200_001), series).T
    run_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    path = PolynomialPath(series, 0.3, 0.1, 2.0, 0.4, ahead_m=TURN_M)
    assert path.order == order
    assert path.length_m == pytest.approx(run_m[-1], abs=1e-6)
    times_s = np.linspace(0.0, (path.length_m - 2 * TURN_M) / 0.4, 100)
    swung_m = 0.1 * 2.0 / (2 * math.pi) * (np.sin(math.pi * times_s + 0.4) - math.sin(0.4))
    driven_m = TURN_M + 0.3 * times_s + swung_m
    expected = np.array([np.interp(driven_m, run_m, line[:, axis]) for axis in (0, 1)]).T
    np.testing.assert_allclose(places(path, times_s), expected, atol=2e-4)


@pytest.mark.parametrize("order", ORDERS)
def test_it_goes_to_both_ends_and_its_velocity_never_jumps(order: int) -> None:
    path = PolynomialPath(polynomial(order, 10 + order), 0.6, 0.3, 3.0, 1.0, ahead_m=0.7)
    times_s = np.arange(0.0, 2 * (path.length_m + TURN_M) / 0.6, 0.002)
    found = places(path, times_s)
    for end in (path.through_m[0], path.through_m[-1]):
        assert np.linalg.norm(found - end, axis=1).min() < 1e-3
    velocity = np.diff(found, axis=0) / 0.002
    speed = np.linalg.norm(velocity, axis=1)
    assert speed.max() == pytest.approx(path.speed_mps, rel=2e-3)
    assert path.speed_mps == pytest.approx(0.9)
    sharpest_mps2 = path.speed_mps**2 / path.sharpest_m
    straight_mps2 = 0.3 * 2 * math.pi / 3.0 + path.speed_mps**2 / TURN_M
    change = np.linalg.norm(np.diff(velocity, axis=0), axis=1) / 0.002
    assert change.max() < 1.05 * math.hypot(sharpest_mps2, straight_mps2)


def test_the_sharpest_bend_of_a_parabola_is_at_its_vertex() -> None:
    # y = 2 x^2 over x = -1 to 1: curvature 4 at x = 0.
    assert PolynomialPath(np.array([[0.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), 1.0).sharpest_m == pytest.approx(0.25)
    assert PolynomialPath(np.array([[0.0, 0.0], [1.0, 0.5]]), 1.0).sharpest_m == math.inf


def test_a_path_shorter_than_a_turn_is_followed_to_its_ends() -> None:
    path = PolynomialPath(np.array([[0.0, 0.0], [0.1, 0.0]]), 0.5)
    x = places(path, np.linspace(0.0, 4.0, 4001))[:, 0]
    assert (x.min(), x.max()) == pytest.approx((-0.1, 0.1), abs=1e-5)
    assert np.abs(np.diff(x)).max() <= 0.5 * 0.001 * 1.001
