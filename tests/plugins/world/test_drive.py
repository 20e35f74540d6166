"""Commands act until they are too old, and the pose is known at any time of the last step."""

from __future__ import annotations

import math

import pytest
from graphnav_world.drive import Drive
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Body
from graphnav_world.vehicle import Limits, Vehicle

from graphnav import Latest, Twist

START = (0.0, 0.0, 0.0)
QUICK = Limits(speed_mps=1.0, turn_radps=2.0, speed_up_s=1e-6, turn_up_s=1e-6)
GENTLE = Limits(speed_mps=1.0, turn_radps=2.0, speed_up_s=0.5, turn_up_s=0.5)
AHEAD = Twist(v_mps=0.5, omega_radps=0.0)
CURVE = Twist(v_mps=0.5, omega_radps=0.8)


def driver(limits: Limits = QUICK, timeout_s: float = 0.5) -> Drive:
    return Drive(Vehicle([], START, 0.2, limits), timeout_s)


def test_without_a_command_it_stands() -> None:
    drive = driver()
    drive.hear(Latest(), 0)
    assert drive.advance(300_000).x_m == 0.0


def test_a_command_acts_from_when_it_is_heard() -> None:
    drive = driver()
    drive.hear(Latest(), 0)
    drive.advance(10_000)
    drive.hear(Latest(AHEAD, 0.003), 10_000)
    assert drive.advance(110_000).x_m == pytest.approx(0.05, abs=1e-6)


@pytest.mark.parametrize("age_s", [0.0, 0.123, 0.4])
def test_within_a_long_step_a_command_acts_until_it_is_too_old(age_s: float) -> None:
    drive = driver()
    drive.hear(Latest(AHEAD, age_s), 0)
    assert drive.advance(2_000_000).x_m == pytest.approx(0.5 * (0.5 - age_s), abs=1e-6)
    assert drive.advance(2_010_000).v_mps == 0.0


def test_a_command_that_is_too_old_is_not_obeyed() -> None:
    drive = driver()
    drive.hear(Latest(AHEAD, 0.5001), 0)
    assert drive.advance(100_000).x_m == 0.0


def test_a_command_that_is_heard_again_acts_no_longer() -> None:
    drive = driver()
    for now_us in range(0, 2_000_000, 10_000):
        drive.hear(Latest(AHEAD, now_us / 1e6), now_us)
        pose = drive.advance(now_us + 10_000)
    assert pose.x_m == pytest.approx(0.25, abs=0.006)


def test_it_brakes_within_its_limits() -> None:
    drive = driver(GENTLE)
    drive.hear(Latest(AHEAD, 0.0), 0)
    speeds = {us: drive.advance(us).v_mps for us in range(10_000, 1_000_000, 10_000)}
    assert speeds[500_000] == pytest.approx(0.5)
    assert speeds[600_000] == pytest.approx(0.3)
    assert speeds[760_000] == 0.0


def test_the_pose_is_known_at_any_time_of_the_last_step() -> None:
    drive = driver(timeout_s=10.0)
    drive.hear(Latest(CURVE, 0.0), 0)
    begin_us, radius_m = 0, 0.5 / 0.8
    for end_us in (10_000, 13_001, 52_777, 500_000, 501_000):
        drive.advance(end_us)
        for time_us in (begin_us, begin_us + 1, (begin_us + end_us) // 2, end_us):
            pose, angle = drive.wheels_at(time_us), 0.8 * time_us / 1e6
            expected = radius_m * math.sin(angle), radius_m * (1 - math.cos(angle))
            assert (pose.x_m, pose.y_m) == pytest.approx(expected, abs=2e-5)
            assert pose.yaw_rad == pytest.approx(angle, abs=1e-9)
        begin_us = end_us


def test_yaw_is_interpolated_across_half_a_turn() -> None:
    drive = Drive(Vehicle([], (0.0, 0.0, math.pi - 0.004), 0.2, QUICK), 1.0)
    drive.hear(Latest(Twist(v_mps=0.0, omega_radps=1.0), 0.0), 0)
    drive.advance(10_000)
    assert drive.wheels_at(3_000).yaw_rad == pytest.approx(math.pi - 0.001, abs=1e-9)
    assert drive.wheels_at(5_000).yaw_rad == pytest.approx(-math.pi + 0.001, abs=1e-9)


def test_a_contact_stops_it_for_good() -> None:
    wall = Body.prism(outlines.box(0.5, 0.0, 0.2, 4.0, 0.0), 0.3, "wall")
    drive = Drive(Vehicle([wall], START, 0.2, QUICK), 10.0)
    drive.hear(Latest(AHEAD, 0.0), 0)
    pose = drive.advance(2_000_000)
    assert (pose.contact, pose.v_mps, pose.clearance_m) == (True, 0.0, 0.0)
    assert drive.advance(3_000_000).x_m == pose.x_m


def test_clearance_is_the_minimum_over_the_step() -> None:
    pillar = Body.prism(outlines.box(0.5, 0.6, 0.2, 0.2, 0.0), 0.3, "wall")
    drive = Drive(Vehicle([pillar], START, 0.2, QUICK), 10.0)
    drive.hear(Latest(AHEAD, 0.0), 0)
    assert drive.advance(2_000_000).clearance_m == pytest.approx(0.5 - 0.2, abs=1e-6)
    assert drive.advance(2_010_000).clearance_m == pytest.approx(math.hypot(0.4, 0.5) - 0.2, abs=1e-6)


def test_a_stamp_that_does_not_advance_moves_nothing() -> None:
    drive = driver()
    drive.hear(Latest(AHEAD, 0.0), 0)
    pose = drive.advance(100_000)
    assert drive.advance(100_000) == pose
    assert drive.advance(50_000) == pose
    assert drive.advance(200_000).x_m == pytest.approx(0.1, abs=1e-6)
