"""The control law, within and beyond a right angle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from graphnav_control.nonholonomic import Nonholonomic

from graphnav import Latest, ParamError, Stamp, Steering, Twist

T_M, R_M = 0.4, 1.0


def asked(theta_rad: float) -> Steering:
    force = np.array([-math.sin(theta_rad), math.cos(theta_rad)])
    return Steering(repulsive=np.zeros(2), guiding=force, control=force, theta_rad=theta_rad, eigenvalues=np.zeros(2))


def command(theta_rad: float, **parameters: Any) -> Twist:
    stage = Nonholonomic(max_speed_mps=T_M, max_turn_radps=R_M, **parameters)
    stage.reset(seed=0)
    return stage.step(asked(theta_rad), Latest(), Stamp(0))


@pytest.mark.parametrize("theta_rad", np.linspace(-math.pi / 2, math.pi / 2, 9))
def test_law_of_the_paper_up_to_a_right_angle(theta_rad: float) -> None:
    twist = command(theta_rad)
    assert twist.v_mps == pytest.approx(T_M * math.cos(theta_rad), abs=1e-12)
    assert twist.omega_radps == pytest.approx(R_M * math.sin(theta_rad))


def test_left_is_counterclockwise() -> None:
    assert command(0.5).omega_radps > 0
    assert command(-0.5).omega_radps < 0


@pytest.mark.parametrize("theta_rad", [1.8, 2.5, math.pi])
def test_beyond_a_right_angle_the_robot_turns_on_the_spot(theta_rad: float) -> None:
    for side in (1.0, -1.0):
        twist = command(side * theta_rad)
        assert twist.v_mps == 0.0
        assert twist.omega_radps == side * R_M


@pytest.mark.parametrize("theta_rad", np.linspace(-math.pi, math.pi, 17))
def test_law_of_the_paper_at_every_angle(theta_rad: float) -> None:
    twist = command(theta_rad, reversing=True)
    assert twist.v_mps == pytest.approx(T_M * math.cos(theta_rad), abs=1e-12)
    assert twist.omega_radps == pytest.approx(R_M * math.sin(theta_rad), abs=1e-12)


def test_a_robot_that_reverses_has_no_minimum_speed() -> None:
    with pytest.raises(ParamError, match="no minimum speed"):
        Nonholonomic(reversing=True, floor_ratio=0.3).check()


def test_floor_keeps_the_robot_moving() -> None:
    assert command(2.0, floor_ratio=0.3).v_mps == pytest.approx(0.3 * T_M)
    assert command(0.0, floor_ratio=0.3).v_mps == T_M


def test_low_pass_reaches_63_percent_after_its_time_constant() -> None:
    stage = Nonholonomic(max_speed_mps=T_M, max_turn_radps=R_M, smoothing_s=0.5)
    stage.reset(seed=0)
    stage.step(asked(0.0), Latest(), Stamp(0))
    for k in range(1, 6):
        twist = stage.step(asked(math.pi / 2), Latest(), Stamp(100_000 * k))
    assert twist.omega_radps == pytest.approx(R_M * (1 - math.exp(-1)))
    assert twist.v_mps == pytest.approx(T_M * math.exp(-1))


def test_reset_forgets_the_last_command() -> None:
    stage = Nonholonomic(smoothing_s=10.0)
    for _ in range(2):
        stage.reset(seed=0)
        assert stage.step(asked(math.pi / 2), Latest(), Stamp(0)).omega_radps == pytest.approx(stage.max_turn_radps)
        stage.step(asked(0.0), Latest(), Stamp(100_000))


def test_after_a_gap_the_low_pass_restarts() -> None:
    stage = Nonholonomic(max_speed_mps=T_M, max_turn_radps=R_M, smoothing_s=10.0)
    stage.reset(seed=0)
    for k in range(4):
        stage.step(asked(0.0), Latest(), Stamp(100_000 * k))
    assert stage.step(asked(math.pi / 2), Latest(), Stamp(610_000)).omega_radps == R_M
    assert stage.step(asked(0.0), Latest(), Stamp(710_000)).omega_radps == pytest.approx(R_M * math.exp(-0.01))
