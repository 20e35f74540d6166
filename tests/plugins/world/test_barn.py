"""Worlds of the BARN challenge: their cylinders, start and goal, and which of them a seed names."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from graphnav_world.geometry import outlines
from graphnav_world.geometry.scene import Kind
from graphnav_world.maps.world_map import WorldMap, load_map
from graphnav_world.world import Pymunk

from graphnav import Latest, Map, Stamp, Twist
from graphnav.core.stage import tell_run_seed

RADIUS_M = 0.27


@pytest.fixture
def written(tmp_path: Path) -> Path:
    path = tmp_path / "barn.yaml"
    path.write_text("barn: {world: 49}\n")
    return path


def middles(world: WorldMap) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return the centres of the obstacles, (n, 2)."""
    return np.array([body.outline.mean(axis=0) for body in world.draw.bodies if body.kind == Kind.OBSTACLE])


def test_the_robot_starts_in_a_lane_that_leads_to_the_field(written: Path) -> None:
    world = load_map(written, 0, RADIUS_M)
    found = middles(world)
    assert world.draw.start == (-2.25, 3.0, math.pi / 2)
    assert 181 <= len(found) <= 365
    columns, rows = (found[:, 0] + 4.425) / 0.15, (found[:, 1] - 0.075) / 0.15
    assert np.abs(columns - columns.round()).max() < 1e-9
    assert np.abs(rows - rows.round()).max() < 1e-9
    cells = set(zip(columns.round().astype(int).tolist(), rows.round().astype(int).tolist(), strict=True))
    assert {(column, row) for column in (0, 29) for row in range(64)} <= cells
    assert not {(column, row) for column in range(1, 29) for row in range(1, 33)} & cells
    assert {body.height_m for body in world.draw.bodies} == {1.0}
    cylinder = world.draw.bodies[0].outline
    assert np.hypot(*(cylinder - cylinder.mean(axis=0)).T) == pytest.approx(np.full(16, 0.075))


def test_the_goal_is_the_circle_of_a_metre(written: Path) -> None:
    goal_m = load_map(written, 0, RADIUS_M).draw.goal_m
    for angle in np.linspace(0, 2 * math.pi, 37):
        x, y = -2.25 + math.cos(angle) * np.array([0.999, 1.001]), 13 + math.sin(angle) * np.array([0.999, 1.001])
        assert [outlines.contains(goal_m, *point) for point in zip(x, y, strict=True)] == [True, False]


def test_the_run_s_seed_is_the_number_of_the_world(maps: Path, written: Path) -> None:
    wanted = middles(load_map(written, 0, RADIUS_M))
    for run_seed in (49, 349):
        assert (middles(load_map(maps / "barn.yaml", 7, RADIUS_M, run_seed)) == wanted).all()
    assert len(middles(load_map(maps / "barn.yaml", 49, RADIUS_M, 50))) != len(wanted)


def test_a_graph_s_world_has_the_number_of_its_run(maps: Path) -> None:
    counts = []
    for run_seed in (None, 49):
        world = Pymunk(map=maps / "barn.yaml", size=(16, 12))
        if run_seed is not None:
            tell_run_seed(world, run_seed)
        world.reset(seed=5)
        drawn = world.step(Latest[Twist](), Stamp(0)).map
        assert drawn is not None
        counts.append(int((drawn.kind == Map.OBSTACLE).sum()))
    assert counts == [len(middles(load_map(maps / "barn.yaml", number, RADIUS_M))) for number in (5, 49)]


def test_a_range_draws_the_number_from_the_seed(tmp_path: Path) -> None:
    path = tmp_path / "barn.yaml"
    path.write_text("barn: {world: [1, 2]}\n")
    counts = {len(middles(load_map(path, seed, RADIUS_M))) for seed in range(12)}
    assert counts == {len(middles(load_map(maps_world(tmp_path, number), 0, RADIUS_M))) for number in (1, 2)}


def maps_world(folder: Path, number: int) -> Path:
    path = folder / f"{number}.yaml"
    path.write_text(f"barn: {{world: {number}}}\n")
    return path


def test_a_rectangular_robot_is_on_the_map(maps: Path) -> None:
    world = Pymunk(map=maps / "barn.yaml", size=(16, 12), robot_size_m=(0.508, 0.43))
    world.reset(seed=1)
    drawn = world.step(Latest[Twist](), Stamp(0)).map
    assert drawn is not None
    assert drawn.robot_radius_m == pytest.approx(math.hypot(0.508, 0.43) / 2)
    outline = drawn.robot_outline_m
    assert outline is not None
    assert np.abs(outline).max(axis=0) == pytest.approx([0.254, 0.215])
    around = drawn.surroundings()
    assert (around.kind != Map.ROBOT).all()
    assert len(around.kind) == len(drawn.kind) - 1
    assert len(around.vertices_m) == len(around.body) == len(drawn.vertices_m) - 4
    assert around.surroundings() is around
    assert around.robot_outline_m is None
