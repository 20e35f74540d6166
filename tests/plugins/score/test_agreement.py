"""Steering beside an oracle's, worked by hand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import pytest
from graphnav_score.agreement import Agreement

from graphnav import Steering


def steering(theta_deg: float) -> Steering:
    theta_rad = math.radians(theta_deg)
    force = np.array([-math.sin(theta_rad), math.cos(theta_rad)])
    nothing = np.zeros(2)
    return Steering(repulsive=nothing, guiding=force, control=force, theta_rad=theta_rad, eigenvalues=nothing)


def summary(pairs_deg: Sequence[tuple[float, float]], min_turn_deg: float = 5.0) -> Mapping[str, float]:
    stage = Agreement(min_turn_deg=min_turn_deg)
    stage.reset(seed=0)
    for theta_deg, oracle_deg in pairs_deg:
        stage.step(steering(theta_deg), steering(oracle_deg))
    return stage.summary()


def test_metrics() -> None:
    metrics = summary([(10.0, 20.0), (-5.0, 15.0), (0.0, 30.0), (-40.0, -10.0), (3.0, -4.0)])
    assert metrics["frames"] == 5
    assert metrics["angle_error_rad"] == pytest.approx(math.radians((10 + 20 + 30 + 30 + 7) / 5))
    assert metrics["right_sign_ratio"] == 2 / 4


@pytest.mark.parametrize(("theta_deg", "oracle_deg", "error_deg"), [(170, -170, 20), (-175, 180, 5), (90, -90, 180)])
def test_error_goes_the_short_way_around(theta_deg: float, oracle_deg: float, error_deg: float) -> None:
    assert summary([(theta_deg, oracle_deg)])["angle_error_rad"] == pytest.approx(math.radians(error_deg))


def test_an_oracle_agrees_with_itself() -> None:
    metrics = summary([(angle, angle) for angle in range(-170, 180, 10)])
    assert (metrics["angle_error_rad"], metrics["right_sign_ratio"]) == (0.0, 1.0)


def test_what_is_not_defined_is_left_out() -> None:
    assert summary([]) == {"frames": 0.0}
    assert summary([(1.0, 4.9)]).keys() == {"frames", "angle_error_rad"}
    assert "right_sign_ratio" not in summary([(1.0, 0.0)], min_turn_deg=0.0), "straight ahead has no side"
