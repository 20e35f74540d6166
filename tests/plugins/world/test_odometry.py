"""Odometry adds up what it reads: exact without errors, drifting with them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from graphnav_world.odometry import DeadReckoning, OdometryErrors
from graphnav_world.vehicle import Pose


def errors(scale_ratio: float, noise_ratio: float, seed: int = 0) -> OdometryErrors:
    return OdometryErrors(np.random.default_rng(seed), scale_ratio, noise_ratio)


def pose(x_m: float, y_m: float, yaw_rad: float, v_mps: float = 0.0, omega_radps: float = 0.0) -> Pose:
    return Pose(x_m, y_m, math.remainder(yaw_rad, 2 * math.pi), v_mps, omega_radps, 1.0, contact=False)


def test_without_errors_the_pose_is_exact_in_the_frame_of_the_start() -> None:
    rng = np.random.default_rng(4)
    start = pose(3.0, -2.0, 2.5)
    reckoning = DeadReckoning(start, errors(0.0, 0.0))
    for k in range(50):
        x_m, y_m, yaw_rad = rng.uniform([-4.0, -4.0, -3.0], [4.0, 4.0, 3.0])
        now = pose(x_m, y_m, yaw_rad, 0.4, -0.7)
        read = reckoning.read(now, 0.02 * k)
        x, y = now.x_m - start.x_m, now.y_m - start.y_m
        c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
        assert (read.x_m, read.y_m) == pytest.approx((c * x + s * y, c * y - s * x), abs=1e-9)
        assert math.remainder(read.yaw_rad - now.yaw_rad + start.yaw_rad, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
        assert (read.v_mps, read.omega_radps) == (0.4, -0.7)
        assert abs(read.yaw_rad) <= math.pi


def test_where_it_begins_is_zero() -> None:
    read = DeadReckoning(pose(1.0, 2.0, 3.0), errors(0.02, 0.01)).read(pose(1.0, 2.0, 3.0), 0.0)
    assert (read.x_m, read.y_m, read.yaw_rad) == (0.0, 0.0, 0.0)


def test_scale_errors_add_up_and_show_in_the_speeds() -> None:
    ratios = set()
    for seed in range(8):
        reckoning = DeadReckoning(pose(0.0, 0.0, 0.0), errors(0.02, 0.0, seed))
        for k in range(1, 101):
            read = reckoning.read(pose(0.05 * k, 0.0, 0.0, v_mps=0.5), 0.1 * k)
        assert read.x_m / 5.0 == pytest.approx(read.v_mps / 0.5)
        assert (read.y_m, read.yaw_rad) == (0.0, 0.0)
        ratios.add(round(read.x_m / 5.0, 6))
    assert ratios == {0.98, 1.02}


def test_noise_accumulates_as_a_random_walk() -> None:
    ends = []
    for seed in range(200):
        reckoning = DeadReckoning(pose(0.0, 0.0, 0.0), errors(0.0, 0.1, seed))
        for k in range(1, 101):
            read = reckoning.read(pose(0.01 * k, 0.0, 0.0), 0.02 * k)
        ends.append(read.x_m)
    # 100 readings, each with a deviation of 1 mm; the estimate from 200 of them is good to 5 %.
    assert np.std(ends) == pytest.approx(0.01, rel=0.2)
    assert np.mean(ends) == pytest.approx(1.0, abs=0.003)
