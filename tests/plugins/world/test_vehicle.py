"""The robot's body: it drives as a unicycle within its limits and notices what it touches."""

from __future__ import annotations

import math

import numpy as np
import pytest
from graphnav_world.geometry import outlines
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.scene import Body
from graphnav_world.vehicle import Limits, Vehicle

QUICK = Limits(speed_mps=1.0, turn_radps=2.0, speed_up_s=1e-6, turn_up_s=1e-6)
SLUGGISH = Limits(speed_mps=1.0, turn_radps=2.0, speed_up_s=0.5, turn_up_s=0.4)
START = (0.0, 0.0, 0.0)
WALL = Body.prism(outlines.box(1.5, 0.0, 0.2, 4.0, 0.0), 0.3, "wall")


def test_a_constant_command_drives_a_circle() -> None:
    vehicle = Vehicle([], START, 0.2, QUICK)
    for k in range(1, 21):
        pose = vehicle.advance(0.5, 0.8, 0.1 * k)
        angle, radius = 0.8 * 0.1 * k, 0.5 / 0.8
        expected = radius * math.sin(angle), radius * (1 - math.cos(angle))
        assert (pose.x_m, pose.y_m) == pytest.approx(expected, abs=2e-5)
        assert pose.yaw_rad == pytest.approx(angle, abs=1e-9)


def test_it_never_slips_sideways() -> None:
    vehicle = Vehicle([], (0.0, 0.0, 1.0), 0.2, SLUGGISH)
    rng = np.random.default_rng(0)
    then = vehicle.pose
    for k in range(1, 200):
        v, omega = rng.uniform([-1, -2], [1, 2])
        now = vehicle.advance(v, omega, 0.01 * k)
        midway = (then.yaw_rad + math.remainder(now.yaw_rad - then.yaw_rad, 2 * math.pi) / 2) + math.pi / 2
        aside = (now.x_m - then.x_m) * math.cos(midway) + (now.y_m - then.y_m) * math.sin(midway)
        assert abs(aside) < 1e-9
        then = now


def test_speed_and_turning_rate_stay_within_the_limits_and_change_gradually() -> None:
    vehicle = Vehicle([], START, 0.2, SLUGGISH)
    speeds = []
    for k in range(1, 11):
        pose = vehicle.advance(5.0, -9.0, 0.1 * k)
        speeds.append((pose.v_mps, pose.omega_radps))
    v, omega = np.array(speeds).T
    np.testing.assert_allclose(v, np.minimum(0.2 * np.arange(1, 11), 1.0), atol=1e-9)
    np.testing.assert_allclose(omega, np.maximum(-0.5 * np.arange(1, 11), -2.0), atol=1e-9)
    stopped = vehicle.advance(0.0, 0.0, 2.0)
    assert (stopped.v_mps, stopped.omega_radps) == (0.0, 0.0)


def test_the_first_contact_stops_it_for_good() -> None:
    vehicle = Vehicle([WALL], START, 0.2, QUICK)
    poses = [vehicle.advance(0.5, 0.0, 0.1 * k) for k in range(1, 40)]
    first = next(k for k, pose in enumerate(poses) if pose.contact)
    assert poses[first].x_m == pytest.approx(1.4 - 0.2, abs=0.012)
    assert poses[first].clearance_m == 0.0
    assert all(pose.x_m == poses[first].x_m for pose in poses[first:])
    assert not any(pose.contact for pose in poses[:first])


def test_clearance_is_from_the_rim_to_the_nearest_body_at_its_least() -> None:
    pillar = Body.prism(outlines.box(0.5, 0.6, 0.2, 0.2, 0.0), 0.3, "wall")
    vehicle = Vehicle([pillar], START, 0.2, QUICK)
    assert vehicle.pose.clearance_m == pytest.approx(math.hypot(0.4, 0.5) - 0.2, abs=1e-6)
    passed = vehicle.advance(1.0, 0.0, 1.0)
    assert passed.x_m == pytest.approx(1.0)
    assert passed.clearance_m == pytest.approx(0.5 - 0.2, abs=1e-6)


def test_a_moving_obstacle_hits_a_robot_that_stands() -> None:
    path = Patrol(np.array([[2.0, 0.0], [-2.0, 0.0]]), speed_mps=0.5)
    vehicle = Vehicle([Body.prism(outlines.circle(0, 0, 0.1), 0.3, "wall", path)], START, 0.2, QUICK)
    contact_s = next(0.1 * k for k in range(1, 60) if vehicle.advance(0.0, 0.0, 0.1 * k).contact)
    assert contact_s == pytest.approx((2.0 - 0.3) / 0.5, abs=0.11)


def test_a_patrol_goes_back_the_way_it_came_or_around() -> None:
    stops = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0]])
    back, around = Patrol(stops, 1.0), Patrol(stops, 1.0, around=True, ahead_m=0.5)
    there = np.array([back.at(t) for t in (0, 2.5, 3, 4, 6)])
    np.testing.assert_allclose(there, np.array([[0, 0], [2, 0.5], [2, 1], [2, 0], [0, 0]]))
    length = 3 + math.sqrt(5)
    np.testing.assert_allclose(around.at(length), [0.5, 0.0], atol=1e-12)
    np.testing.assert_allclose(around.at(2.5 + math.sqrt(5) / 2), [1.0, 0.5])
    np.testing.assert_allclose(Patrol(stops, 0.0).at(9.0), [0, 0])


def test_the_same_commands_lead_to_the_same_pose_bit_for_bit() -> None:
    commands = np.random.default_rng(3).uniform([0, -2], [0.6, 2], (60, 2))
    one, same = (Vehicle([WALL], START, 0.2, SLUGGISH) for _ in range(2))
    for k, (v, omega) in enumerate(commands, start=1):
        assert one.advance(v, omega, 0.1 * k) == same.advance(v, omega, 0.1 * k)


def test_clearance_is_the_distance_to_the_nearest_body_of_all() -> None:
    rng = np.random.default_rng(2)
    pillars = [Body.prism(outlines.circle(x, y, 0.1), 0.3, "wall") for x, y in rng.uniform(-4, 4, (30, 2))]
    paths = [Patrol(rng.uniform(-3, 3, (3, 2)), speed_mps=2.0, around=True) for _ in range(5)]
    movers = [Body.prism(outlines.box(0, 0, 0.3, 0.2, 0.4), 0.3, "wall", path) for path in paths]
    vehicle = Vehicle([*pillars, *movers], (0.0, 0.0, 0.3), 0.01, SLUGGISH)
    for k in range(1, 400):
        pose = vehicle.advance(0.6, 0.3 * math.sin(k / 30), 0.01 * k)
        if pose.contact:
            break
        outlines_m = [
            *(body.outline for body in pillars),
            *(b.outline + p.at(0.01 * k) for b, p in zip(movers, paths, strict=True)),
        ]
        nearest = min(outlines.distance(outline, pose.x_m, pose.y_m) for outline in outlines_m) - 0.01
        assert vehicle._here_m == pytest.approx(nearest, abs=1e-6)
        assert pose.clearance_m <= nearest + 1e-6
    assert k > 30


JACKAL = (0.508, 0.43)


def _rectangle(bodies: list[Body], start: tuple[float, float, float]) -> Vehicle:
    return Vehicle(bodies, start, math.hypot(*JACKAL) / 2, QUICK, size_m=JACKAL)


@pytest.mark.parametrize("heading_deg", [0, 17, 45, 90, 200])
def test_a_rectangle_keeps_the_distance_of_its_sides_and_corners(heading_deg: int) -> None:
    yaw = math.radians(heading_deg)
    pillar = Body.prism(outlines.box(0.3, 0.9, 0.2, 0.1, 0.4), 0.3, "wall")
    vehicle = _rectangle([WALL, pillar], (0.0, 0.0, yaw))
    rim = outlines.box(0.0, 0.0, *JACKAL, yaw)
    ends = zip(rim, np.roll(rim, -1, axis=0), strict=True)
    sides = np.concatenate([a + np.linspace(0, 1, 400)[:, None] * (b - a) for a, b in ends])
    nearest = min(outlines.distance(body.outline, *point) for body in (WALL, pillar) for point in sides)
    assert vehicle.pose.clearance_m == pytest.approx(nearest, abs=2e-3)


@pytest.mark.parametrize(("heading_rad", "half_m"), [(0.0, 0.254), (math.pi, 0.254)])
def test_a_rectangle_touches_with_its_front_and_its_back(heading_rad: float, half_m: float) -> None:
    vehicle = _rectangle([WALL], (0.0, 0.0, heading_rad))
    poses = [vehicle.advance(0.5 * math.cos(heading_rad), 0.0, 0.1 * k) for k in range(1, 40)]
    first = next(pose for pose in poses if pose.contact)
    assert first.x_m == pytest.approx(1.4 - half_m, abs=0.012)
    assert first.clearance_m == 0.0


def test_a_rectangle_touches_beside_what_it_can_pass_when_it_turns() -> None:
    beside = [Body.prism(outlines.box(0.0, side * 0.33, 3.0, 0.2, 0.0), 0.3, "wall") for side in (-1, 1)]
    passing = _rectangle(beside, START)
    assert not passing.advance(0.5, 0.0, 1.0).contact
    assert passing.pose.clearance_m == pytest.approx(0.23 - 0.215, abs=1e-6)
    assert passing.advance(0.0, 1.0, 2.0).contact, "a corner is farther from the middle than the wall"
