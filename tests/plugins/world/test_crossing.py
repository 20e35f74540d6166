"""Obstacles that wait for the robot and cross its way."""

from __future__ import annotations

import itertools
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.geometry.crossing import Crossing
from graphnav_world.geometry.movers import Walker
from graphnav_world.maps.world_map import load_map
from graphnav_world.robot import Robot
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Finished, Latest, Stamp, State, Twist
from graphnav.testing import check_stage

AHEAD = Twist(v_mps=0.4, omega_radps=0.0)
QUICK: dict[str, Any] = {"speed_up_s": 1e-6, "turn_up_s": 1e-6}
LINE = np.array([[2.0, -1.0], [2.0, 1.0]])


def a_map(folder: Path, crosses: str) -> Path:
    path = folder / "map.yaml"
    path.write_text(
        "start: {at_m: [0, 0]}\n"
        "obstacles:\n"
        "  - {circle: {center_m: [0.5, 1.5], radius_m: 0.2}, height_m: 0.4}\n"
        f"  - circle: {{center_m: [2, -1], radius_m: 0.15}}\n    height_m: 0.4\n    crosses: {crosses}\n"
    )
    return path


def states(world: Pymunk, twist: Twist, ticks: int, seed: int = 3) -> list[State]:
    return [out.state for out in outputs(world, twist, ticks, seed)]


def outputs(world: Pymunk, twist: Twist, ticks: int, seed: int = 3) -> list[WorldOutputs]:
    world.reset(seed)
    found: list[WorldOutputs] = []
    for k in range(ticks):
        try:
            found.append(world.step(Latest(twist, 0.1), Stamp(k * 100_000)))
        except Finished as end:
            return [*found, end.outputs]
    return found


def test_it_waits_walks_at_constant_speed_and_stays() -> None:
    walk = Crossing(LINE, 0.5, within_m=1.0)
    assert [walk.at(s) for s in (-1.0, 0.0, 1.0, 4.0, 9.0)] == [(2, -1), (2, -1), (2, -0.5), (2, 1), (2, 1)]


def test_it_returns_as_it_came_and_stays_where_it_waited() -> None:
    walk = Crossing(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]), 0.5, within_m=1.0, returns=True)
    places = np.array([walk.at(s) for s in (0.0, 1.0, 3.0, 4.0, 5.0, 7.0, 8.0, 50.0)])
    expected = np.array([[0, 0], [0.5, 0], [1, 0.5], [1, 1], [1, 0.5], [0.5, 0], [0, 0], [0, 0]])
    np.testing.assert_allclose(places, expected, atol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_it_sets_out_when_the_line_will_be_reached_in_time(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot, velocity, (a, b) = rng.uniform(-2, 2, 2), rng.uniform(-1, 1, 2), rng.uniform(-2, 2, (2, 2))
    walk = Crossing(np.array([a, b]), 0.3, within_s=3.0)
    times = np.linspace(0.0, 3.0, 3001)
    ways = robot + times[:, None] * velocity
    side = np.sign(np.cross(np.append(b - a, 0.0), np.c_[ways - a, np.zeros(len(ways))])[:, 2])
    turns = np.flatnonzero(np.diff(side))
    along = (ways[turns] - a) @ (b - a) / ((b - a) @ (b - a))
    expected = bool(((along >= 0.0) & (along <= 1.0)).any())
    assert walk.is_due((robot[0], robot[1]), (velocity[0], velocity[1])) == expected


def test_a_robot_that_stands_or_leaves_makes_no_one_set_out_in_time() -> None:
    walk = Crossing(LINE, 0.3, within_s=100.0)
    assert not walk.is_due((0.0, 0.0), (0.0, 0.0))
    assert not walk.is_due((0.0, 0.0), (-0.5, 0.0))
    assert not walk.is_due((0.0, 0.0), (0.1, 0.1)), "it will pass beside the end of the line"
    assert walk.is_due((0.0, 0.0), (0.5, 0.0))


def test_it_stays_set_out_when_the_robot_is_far_again() -> None:
    walker = Walker(Crossing(LINE, 0.5, within_m=1.0))
    walker.see(1.0, (0.0, 0.0), (0.0, 0.0))
    assert walker.at(1.5) == (2.0, -1.0)
    walker.see(2.0, (2.0, -0.2), (0.0, 0.0))
    walker.see(3.0, (9.0, 9.0), (0.0, 0.0))
    assert walker.at(3.0) == pytest.approx((2.0, -0.5))
    assert walker.at(1.0) == (2.0, -1.0)


@pytest.mark.parametrize(
    ("crosses", "sets_out_at_m"),
    [
        ("{through_m: [[2, 3]], speed_mps: 0.3, within_m: 1.5}", 2 - math.sqrt(1.5**2 - 1)),
        ("{through_m: [[2, 3]], speed_mps: 0.3, within_s: 2}", 2 - 2 * 0.4),
    ],
)
def test_it_depends_on_the_drive_when_it_sets_out(crosses: str, sets_out_at_m: float, tmp_path: Path) -> None:
    path = a_map(tmp_path, crosses)
    for v_mps, ahead_s in ((0.4, 0.0), (0.0, math.inf)):
        drive = states(Pymunk(map=path, **QUICK), Twist(v_mps=v_mps, omega_radps=0.0), 45)
        for k, state in enumerate(drive):
            walked_m = 0.3 * max(0.0, 0.1 * k - sets_out_at_m / 0.4 - ahead_s)
            assert state.moving[0] == pytest.approx([2.0, -1.0 + walked_m, 0.0], abs=0.3 * 0.0101)


def test_numbers_are_drawn_from_their_ranges(tmp_path: Path) -> None:
    path = a_map(tmp_path, "{through_m: [[2, [1, 2]]], speed_mps: [0.1, 0.5], within_m: [1, 2], returns: true}")
    courses = [load_map(path, seed, 0.2).draw.bodies[1].course for seed in range(12)]
    drawn = np.array([(c.speed_mps, c.within_m, c.through_m[1, 1]) for c in courses if isinstance(c, Crossing)])
    assert drawn.shape == (12, 3)
    assert (drawn >= [0.1, 1, 1]).all()
    assert (drawn <= [0.5, 2, 2]).all()
    assert (np.ptp(drawn, axis=0) > [0.15, 0.4, 0.4]).all()


def test_true_flow_is_that_of_the_body_that_walks(tmp_path: Path) -> None:
    path = a_map(tmp_path, "{through_m: [[2, 1]], speed_mps: 0.3, within_m: 1.6}")
    drive = outputs(Pymunk(map=path, noise_sigma_gray=0.0, **QUICK), AHEAD, 30)
    map_drawn = load_map(path, 3, 0.2).draw
    seen = 0
    for before, now in itertools.pairwise(drive):
        assert now.truth is not None
        moved = now.state.moving[0, :2] - before.state.moving[0, :2]
        seen += _check_flow(before.state, now, moved, map_drawn.bodies[1].outline)
    assert seen > 1000, "pixels of the walker, seen while it walks"


def _check_flow(before: State, now: WorldOutputs, moved: Any, outline: Any) -> int:
    """Compare the flow of the walker's pixels with a projection of its points; return how many there are."""
    assert now.truth is not None
    focal_px, tilt = 80 / math.tan(math.radians(35)), math.radians(75)
    x, y = np.meshgrid(np.arange(160) - 79.5, np.arange(120) - 59.5)
    depth = now.truth.depth_m.astype(float)
    forward = depth * (math.cos(tilt) - y / focal_px * math.sin(tilt))
    height = 1.0 - depth * (math.sin(tilt) + y / focal_px * math.cos(tilt))
    left = -depth * x / focal_px
    c, s = math.cos(now.state.yaw_rad), math.sin(now.state.yaw_rad)
    east, north = now.state.x_m + c * forward - s * left, now.state.y_m + s * forward + c * left
    reach = np.linalg.norm(outline, axis=1).max() + 1e-3
    on_it = np.hypot(east - now.state.moving[0, 0], north - now.state.moving[0, 1]) < reach
    on_it &= now.truth.obstacle == 1
    c, s = math.cos(before.yaw_rad), math.sin(before.yaw_rad)
    east, north = east - moved[0] - before.x_m, north - moved[1] - before.y_m
    forward, left = c * east + s * north, -s * east + c * north
    deep = forward * math.cos(tilt) + (1.0 - height) * math.sin(tilt)
    down = (1.0 - height) * math.cos(tilt) - forward * math.sin(tilt)
    expected = np.stack([x + focal_px * left / deep, y - focal_px * down / deep], axis=-1)
    np.testing.assert_allclose(now.truth.flow_px[on_it], expected[on_it], atol=2e-3)
    return int(on_it.sum()) if np.linalg.norm(moved) > 0.02 else 0


def test_the_same_seed_and_commands_give_the_same_walk(tmp_path: Path) -> None:
    path = a_map(tmp_path, "{through_m: [[2, 1]], speed_mps: 0.3, within_m: 1.6}")
    steps = [{"command": Latest(AHEAD, 0.1), "utime": Stamp(k * 100_000)} for k in range(35)]
    check_stage(Pymunk, *steps, map=str(path), size=(32, 24))


def test_both_worlds_walk_alike(tmp_path: Path) -> None:
    path = a_map(tmp_path, "{through_m: [[2, 3]], speed_mps: 0.3, within_s: 2}")
    robot = Robot(map=path, state_hz=100.0, size=(32, 24), command_timeout_s=9.0, **QUICK)
    robot.reset(3)
    steps = [robot.step(Latest(AHEAD, 0.0), Stamp(us)).state for us in range(0, 4_000_001, 10_000)]
    for k, state in enumerate(states(Pymunk(map=path, **QUICK), AHEAD, 41)):
        other = steps[10 * k]
        assert other is not None
        assert other.moving == pytest.approx(state.moving, abs=1e-9)


def test_two_drives_of_one_world_do_not_share_who_has_set_out(tmp_path: Path) -> None:
    path = a_map(tmp_path, "{through_m: [[2, 3]], speed_mps: 0.3, within_m: 1.5}")
    first, second = (states(Pymunk(map=path, **QUICK), AHEAD, 40) for _ in range(2))
    assert [one.moving.tolist() for one in first] == [one.moving.tolist() for one in second]
    assert second[0].moving[0, 1] == -1.0
    assert second[-1].moving[0, 1] > -1.0
