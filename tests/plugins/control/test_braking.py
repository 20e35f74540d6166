"""The speed before an obstacle follows from the limits that a base declares and the delays as measured."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from graphnav_control.nonholonomic import (
    Braking,
    Nonholonomic,
    free_way_m,
    safe_speed_mps,
    speed_around_mps,
)
from graphnav_world.delay_line import DelayLine
from graphnav_world.vehicle import Limits, Vehicle
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from graphnav import Age, BaseLimits, Latest, LocalMap, Stamp, Steering, Twist

DrawMap = Callable[..., LocalMap]
RADIUS_M = 0.2
WITHIN_M = RADIUS_M, RADIUS_M
"""No margin on arcs."""
PERIOD_US = 50_000
AHEAD = Steering(
    repulsive=np.zeros(2), guiding=np.zeros(2), control=np.zeros(2), theta_rad=0.0, eigenvalues=np.zeros(2)
)
BASE = BaseLimits(
    max_speed_mps=2.0,
    max_turn_radps=3.0,
    max_accel_mps2=4.0,
    max_decel_mps2=4.0,
    max_turn_accel_radps2=12.0,
    latency_s=0.0,
)


def control(**parameters: Any) -> Nonholonomic:
    stage = Nonholonomic(**({"max_speed_mps": 5.0, "robot_radius_m": RADIUS_M} | parameters))
    stage.reset(seed=0)
    return stage


def speed_mps(
    stage: Nonholonomic,
    map_: LocalMap,
    base: BaseLimits | None,
    stamps_us: Iterable[int] = (0, PERIOD_US),
    age_s: float = 0.0,
) -> float:
    """Return the speed of the last command."""
    twist = Twist(0.0, 0.0)
    for utime in stamps_us:
        twist = stage.step(AHEAD, Latest(map_, 0.0), Stamp(utime), Latest(base), Age(age_s))
    return twist.v_mps


@pytest.fixture
def wall(draw_map: DrawMap) -> LocalMap:
    """A wall ahead: the way to it is 0.625 m, up to which the command grows."""
    return draw_map(lambda x, _: x > 0.875)


def way_m(wall: LocalMap) -> float:
    """Return the way to the wall, as the law itself finds it."""
    # At 0.5 m/s2 without reaction v^2 = way.
    return speed_mps(control(max_decel_mps2=0.5, reaction_s=0.0), wall, None) ** 2


def test_without_limits_it_counts_on_half_a_metre_per_second_squared_after_a_quarter_second(wall: LocalMap) -> None:
    assert speed_mps(control(), wall, None) == pytest.approx(safe_speed_mps(way_m(wall), 0.5, 0.25))


def test_by_default_it_counts_on_half_of_the_deceleration_after_twice_the_reaction(wall: LocalMap) -> None:
    base = replace(BASE, latency_s=0.07)
    expected = safe_speed_mps(way_m(wall), 2.0, 2 * (0.05 + 0.07 + 0.03))
    assert speed_mps(control(), wall, base, age_s=0.03) == pytest.approx(expected)


def test_both_margins_are_parameters(wall: LocalMap) -> None:
    stage = control(decel_ratio=0.8, reaction_ratio=3.0)
    assert speed_mps(stage, wall, BASE) == pytest.approx(safe_speed_mps(way_m(wall), 3.2, 0.15))


@pytest.mark.parametrize("base", [None, BASE])
def test_what_the_graph_says_wins(wall: LocalMap, base: BaseLimits | None) -> None:
    stage = control(max_decel_mps2=1.0, reaction_s=0.1)
    assert speed_mps(stage, wall, base) == pytest.approx(safe_speed_mps(way_m(wall), 1.0, 0.1))


def test_the_first_image_has_no_period(wall: LocalMap) -> None:
    assert speed_mps(control(), wall, BASE, [0]) == pytest.approx(safe_speed_mps(way_m(wall), 2.0, 0.25))


def test_the_longest_delay_of_the_last_five_counts(wall: LocalMap) -> None:
    late = [0, 50_000, 100_000, 220_000]  # one image was overtaken

    def after(images: int) -> float:
        return speed_mps(control(), wall, BASE, [*late, *(220_000 + PERIOD_US * (k + 1) for k in range(images))])

    assert after(0) == after(4) == pytest.approx(safe_speed_mps(way_m(wall), 2.0, 2 * 0.12))
    assert after(5) == pytest.approx(safe_speed_mps(way_m(wall), 2.0, 2 * 0.05))


def test_a_gap_is_not_a_delay(wall: LocalMap) -> None:
    stamps_us = [0, 50_000, 100_000, 5_000_000, 5_050_000]
    assert speed_mps(control(), wall, BASE, stamps_us) == pytest.approx(safe_speed_mps(way_m(wall), 2.0, 2 * 0.05))


@settings(max_examples=50, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(decel=st.floats(0.05, 10.0), slower=st.floats(0.1, 0.9), latency_s=st.floats(0.0, 1.0))
def test_a_base_that_brakes_less_or_later_is_driven_more_slowly(
    wall: LocalMap, decel: float, slower: float, latency_s: float
) -> None:
    def driven_mps(base: BaseLimits) -> float:
        return speed_mps(control(), wall, base)

    base = replace(BASE, max_speed_mps=100.0, max_decel_mps2=decel, latency_s=latency_s)
    assert driven_mps(replace(base, max_decel_mps2=decel * slower)) < driven_mps(base)
    assert driven_mps(replace(base, latency_s=latency_s + 0.1)) < driven_mps(base)


@pytest.mark.parametrize("beside_m", [0.05, 0.2, 0.5])
def test_beside_a_wall_it_can_stop_within_its_room(draw_map: DrawMap, beside_m: float) -> None:
    map_ = draw_map(lambda _, y: y > RADIUS_M + beside_m)
    stage = control(map_error_m=0.1)
    room_m = float(map_.obstacle_m_at(np.zeros(1), np.zeros(1))[0]) - RADIUS_M + 0.1
    assert room_m == pytest.approx(beside_m + 0.1, abs=0.05)
    assert speed_mps(stage, map_, BASE) == pytest.approx(min(2.0, safe_speed_mps(room_m, 4.0, 0.1)))
    for told in ({"max_decel_mps2": 2.0}, {"reaction_s": 0.1, "max_decel_mps2": 2.0}):
        assert speed_mps(control(map_error_m=0.1, **told), map_, BASE) == 2.0, "what is given counts ahead alone"


def test_where_the_map_shows_no_room_it_drives_as_if_the_map_were_off(draw_map: DrawMap) -> None:
    # Nearer than the radius at both sides: only the map's error can be right.
    map_ = draw_map(lambda _, y: np.abs(y) > RADIUS_M - 0.05)
    assert speed_mps(control(map_error_m=0.1), map_, BASE) == pytest.approx(safe_speed_mps(0.1, 4.0, 0.1))
    assert speed_mps(control(map_error_m=0.1), map_, None) > 1.0


@settings(max_examples=80, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    v_mps=st.floats(-1.5, 1.5),
    omega_radps=st.floats(-3.0, 3.0),
    has_radps=st.floats(-3.0, 3.0),
    post_m=st.tuples(st.floats(-0.9, 0.9), st.floats(-0.9, 0.9)),
)
def test_on_its_way_it_stops_before_it_comes_too_near(
    draw_map: DrawMap, v_mps: float, omega_radps: float, has_radps: float, post_m: tuple[float, float]
) -> None:
    map_ = draw_map(lambda x, y: np.hypot(x - post_m[0], y - post_m[1]) < 0.08)
    braking = Braking(ahead_mps2=2.0, near_mps2=4.0, reaction_s=0.1, turn_radps=has_radps, turn_radps2=12.0)
    driven_mps = speed_around_mps(map_, Twist(v_mps, omega_radps), 0.0, WITHIN_M, braking)
    assert driven_mps * v_mps >= 0.0
    assert abs(driven_mps) <= abs(v_mps)
    if abs(driven_mps) < 1e-3:
        return
    stop_s = (abs(driven_mps) * 0.1 + driven_mps**2 / 4.0) / abs(driven_mps)
    x_m = y_m = 0.0
    yaw_rad, dt_s = 0.0, stop_s / 500
    here_m = float(map_.obstacle_m_at(np.zeros(1), np.zeros(1))[0])
    while abs(yaw_rad) < math.pi / 2 and stop_s > 0.0:
        midway_rad = yaw_rad + has_radps * dt_s / 2
        x_m, y_m = x_m + driven_mps * dt_s * math.cos(midway_rad), y_m + driven_mps * dt_s * math.sin(midway_rad)
        yaw_rad, stop_s = yaw_rad + has_radps * dt_s, stop_s - dt_s
        has_radps += min(max(omega_radps - has_radps, -12.0 * dt_s), 12.0 * dt_s)
        near_m = float(map_.obstacle_m_at(np.array([x_m]), np.array([y_m]))[0])
        # The law looks at steps of half a cell.
        assert near_m >= min(RADIUS_M, here_m) - 0.03


def test_a_bend_that_would_end_in_a_post_is_driven_more_slowly_and_tighter(draw_map: DrawMap) -> None:
    braking = Braking(ahead_mps2=2.0, near_mps2=4.0, reaction_s=0.1)
    fast = Twist(v_mps=1.2, omega_radps=2.0)
    # To the left of the way straight on: not in the way of a disc that does not turn, nor of one that turns tighter.
    post = draw_map(lambda x, y: np.hypot(x - 0.5, y - 0.35) < 0.08)
    assert free_way_m(post, RADIUS_M) > 1.0
    assert 0.0 < speed_around_mps(post, fast, 0.0, WITHIN_M, braking) < 1.2
    assert speed_around_mps(draw_map(), fast, 0.0, WITHIN_M, braking) == 1.2
    straight = Twist(v_mps=1.2, omega_radps=0.0)
    assert speed_around_mps(post, straight, 0.0, WITHIN_M, braking) == 1.2


def test_an_arc_keeps_as_much_as_the_straight_way_that_it_turns_to(draw_map: DrawMap) -> None:
    braking = Braking(ahead_mps2=2.0, near_mps2=4.0, reaction_s=0.1)
    slow, margin_m = Twist(v_mps=0.3, omega_radps=2.0), 0.1
    within_m = RADIUS_M, RADIUS_M + margin_m
    # Ahead to the right, 0.12 m beside the disc: the arc to the left would pass it at less than the margin.
    post = draw_map(lambda x, y: np.hypot(x - 0.33, y + 0.2) < 0.08)
    assert speed_around_mps(post, slow, math.pi / 3, WITHIN_M, braking) == slow.v_mps
    assert speed_around_mps(post, slow, math.pi / 3, within_m, braking) < slow.v_mps, "what is left leads away from it"
    assert speed_around_mps(post, slow, -0.2, within_m, braking) == slow.v_mps, "what it turns to is as near to it"


def test_a_base_that_still_turns_to_the_other_side_is_driven_more_slowly(draw_map: DrawMap) -> None:
    post = draw_map(lambda x, y: np.hypot(x - 0.4, y - 0.3) < 0.08)
    right = Twist(v_mps=1.0, omega_radps=-2.0)
    speeds_mps = [
        speed_around_mps(post, right, 0.0, WITHIN_M, Braking(2.0, 4.0, 0.1, has_radps, 6.0))
        for has_radps in (-2.0, 0.0, 2.0)
    ]
    assert speeds_mps[0] == 1.0
    assert sorted(speeds_mps, reverse=True) == speeds_mps
    assert speeds_mps[2] < 1.0


def test_the_turning_rate_follows_the_commands_as_fast_as_the_base_declares(draw_map: DrawMap) -> None:
    post = draw_map(lambda x, y: np.hypot(x - 0.4, y - 0.3) < 0.08)

    def driven_mps(accel_radps2: float) -> list[float]:
        base, stage = replace(BASE, max_turn_accel_radps2=accel_radps2), control(max_turn_radps=2.0)
        twists = []
        for k in range(20):  # to the left on the spot, then to the right
            steering = replace(AHEAD, theta_rad=math.pi / 2 if k < 8 else -0.9)
            twists.append(stage.step(steering, Latest(post, 0.0), Stamp(PERIOD_US * k), Latest(base)))
        return [twist.v_mps for twist in twists[8:]]

    slow, quick = driven_mps(6.0), driven_mps(60.0)
    assert slow[0] < quick[0], "it still turns to the left"
    assert slow[-1] == quick[-1], "it has come to turn as told"


def test_no_command_is_faster_than_the_base() -> None:
    base = replace(BASE, max_speed_mps=0.2, max_turn_radps=0.3)
    stage = control(max_speed_mps=1.0, max_turn_radps=1.0)
    twist = stage.step(replace(AHEAD, theta_rad=0.5), Latest(), Stamp(0), Latest(base))
    assert (twist.v_mps, twist.omega_radps) == pytest.approx((0.2 * math.cos(0.5), 0.3 * math.sin(0.5)))


@pytest.mark.parametrize("decel_mps2", [0.3, 1.0, 4.0])
@pytest.mark.parametrize("latency_s", [0.0, 0.1])
def test_a_base_stops_before_a_wall_as_fast_as_it_brakes(
    draw_map: DrawMap, decel_mps2: float, latency_s: float
) -> None:
    base = replace(BASE, max_speed_mps=1.0, max_decel_mps2=decel_mps2, latency_s=latency_s)
    fastest_mps, stopped_m = drive_at_a_wall(draw_map, control(), base)
    assert fastest_mps > 0.6 * min(1.0, math.sqrt(decel_mps2 * 1.5))
    assert -0.1 < stopped_m < 0.0


def test_a_slow_base_that_declares_nothing_hits_the_wall(draw_map: DrawMap) -> None:
    base = replace(BASE, max_speed_mps=1.0, max_decel_mps2=0.3)
    _, told_m = drive_at_a_wall(draw_map, control(), base)
    _, untold_m = drive_at_a_wall(draw_map, control(), base, tells=False)
    assert told_m < 0.0 < untold_m


def drive_at_a_wall(
    draw_map: DrawMap, stage: Nonholonomic, base: BaseLimits, *, tells: bool = True
) -> tuple[float, float]:
    """Drive a vehicle with these limits at a wall; return its maximum speed, and how far its rim is beyond the wall.

    ``tells``: whether the control knows the limits.
    """
    wall_m, start_m = 1.775, -1.0  # the rim of the first cells of the wall
    limits = Limits(base.max_speed_mps, base.max_turn_radps, base.max_speed_mps / base.max_decel_mps2, 0.1)
    vehicle = Vehicle([], (start_m, 0.0, 0.0), RADIUS_M, limits)
    commands: DelayLine[Twist] = DelayLine(round(1e6 * base.latency_s))
    twist, fastest_mps = Twist(0.0, 0.0), 0.0
    for utime in range(0, 12_000_000, PERIOD_US):
        pose = vehicle.pose
        fastest_mps = max(fastest_mps, pose.v_mps)
        map_ = draw_map(lambda x, _: x > wall_m, pose=(pose.x_m, pose.y_m, pose.yaw_rad))
        command = stage.step(AHEAD, Latest(map_, 0.0), Stamp(utime), Latest(base if tells else None))
        commands.put(command, utime)
        for _, due in commands.due(utime):
            twist = due
        vehicle.advance(twist.v_mps, twist.omega_radps, (utime + PERIOD_US) / 1e6)
    return fastest_mps, vehicle.pose.x_m + RADIUS_M - wall_m
