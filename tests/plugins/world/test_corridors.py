"""Corridors of maps, drawn: bends to either side, zigzags, rings; and walls with doors."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from graphnav_world.geometry import outlines
from graphnav_world.maps.map_bodies import cut
from graphnav_world.maps.passage import Passage
from graphnav_world.maps.world_map import WorldMap, load_map

from graphnav import UserError

START = {"start_offset_m": 0, "start_heading_deg": 0}
CORRIDOR = {"radius_m": 3, "half_width_m": 0.6, "bend_deg": 90, "run_in_m": 1.5, "run_out_m": 0.5, **START}
ZIGZAG = {"turn": "left", "corners": 2, "corner_deg": 90, "straight_m": 3, "run_in_m": 2, "half_width_m": 0.6, **START}
RING = {"turn": "left", "length_m": 8, "width_m": 6, "radius_m": 2, "half_width_m": 0.6, **START}
RADIUS_M = 0.2


def drawn(folder: Path, seed: int = 0, **keys: Any) -> WorldMap:
    """Return the draw of a map with these keys; what is drawn is kept by content, so that every test has its own."""
    path = folder / "map.yaml"
    path.write_text(yaml.safe_dump(keys), encoding="utf-8")
    return load_map(path, seed, RADIUS_M)


def clearance_m(world: WorldMap, x_m: float, y_m: float) -> float:
    return min(outlines.distance(part, x_m, y_m) for body in world.draw.bodies for part in body.parts)


def test_either_side_is_drawn_and_left_is_counterclockwise(tmp_path: Path) -> None:
    middles = [
        drawn(tmp_path, seed, corridor={"turn": "either", **CORRIDOR}).draw.goal_m.mean(axis=0) for seed in range(12)
    ]
    sides = [float(np.sign(y)) for _, y in middles]
    assert {-1.0, 1.0} == set(sides)
    left = drawn(tmp_path, corridor={"turn": "left", **CORRIDOR}).draw.goal_m.mean(axis=0)
    for (x, y), side in zip(middles, sides, strict=True):
        assert (x, y) == pytest.approx((left[0], side * left[1]))


def test_a_zigzag_leads_to_its_goal_by_way_of_its_corners(tmp_path: Path) -> None:
    world = drawn(tmp_path, zigzag=ZIGZAG)
    # 2 m along x, 3 m along y, 3 m along x: the goal begins there, and is 0.5 m deep and 1.2 m wide.
    assert world.draw.goal_m.mean(axis=0) == pytest.approx((5.25, 3.0))
    assert np.ptp(world.draw.goal_m, axis=0) == pytest.approx((0.5, 1.2))
    for x, y in ((1.0, 0.0), (2.0, 1.5), (4.0, 3.0)):
        assert clearance_m(world, x, y) == pytest.approx(0.6, abs=1e-6)
    # Shorter than by way of the corners (8 m), longer than straight to the goal.
    assert math.hypot(5, 3) < world.shortest_m < 8.0


def test_a_right_angle_turns_sharply(tmp_path: Path) -> None:
    world = drawn(tmp_path, zigzag={**ZIGZAG, "corners": 1})
    assert clearance_m(world, 2.0, 0.0) == pytest.approx(0.6, abs=1e-6)  # the middle of the corner
    assert clearance_m(world, 2.4, -0.4) == pytest.approx(0.2, abs=1e-6)  # near the outer corner, from both walls


def test_a_dead_end_goes_straight_on_past_the_corner_and_is_closed(tmp_path: Path) -> None:
    world = drawn(tmp_path, zigzag={**ZIGZAG, "corners": 1, "dead_ends": 1, "dead_end_m": 1.0})
    # The corridor that branches off is 0.6 m to either side of x = 2, its wall 0.1 m thick; then 1 m follow.
    end_m = 2.0 + 0.65 + 1.0 - 0.05
    assert clearance_m(world, 3.0, 0.0) == pytest.approx(0.6, abs=1e-6)
    assert clearance_m(world, end_m - 0.3, 0.0) == pytest.approx(0.3, abs=1e-6)
    closed = Passage(world.draw.bodies, (0.0, 0.0, 0.0), np.array([[5.0, -1], [6, -1], [6, 1], [5, 1]]))
    assert not closed.leads_to_goal(RADIUS_M)


@pytest.mark.parametrize("seed", range(20))
def test_zigzags_of_every_seed_have_their_width_everywhere(tmp_path: Path, seed: int) -> None:
    keys = {**ZIGZAG, "turn": "either", "corners": [1, 3], "corner_deg": [60, 95], "straight_m": [2.6, 3.6]}
    world = drawn(tmp_path, seed, zigzag={**keys, "dead_ends": [0, 2], "dead_end_m": [0.3, 0.8]})
    passage = Passage(world.draw.bodies, world.draw.start, world.draw.goal_m)
    assert passage.leads_to_goal(0.55)
    assert not passage.leads_to_goal(0.65)


def test_a_ring_goes_around_without_a_goal(tmp_path: Path) -> None:
    world = drawn(tmp_path, ring=RING)
    assert not len(world.draw.goal_m)
    assert world.shortest_m == 0.0
    corner = 2 * math.sqrt(0.5)
    for x, y in ((0, 0), (4, 3), (0, 6), (-4, 3), (2 + corner, 2 - corner)):
        assert clearance_m(world, x, y) == pytest.approx(0.6, abs=5e-3)
    assert clearance_m(drawn(tmp_path, ring={**RING, "turn": "right"}), 0, -6) == pytest.approx(0.6, abs=5e-3)


def test_a_door_is_an_opening_of_its_width(tmp_path: Path) -> None:
    wall = {"along": [[0, 0], [0, 4]], "doors": [{"at_m": 1.5, "width_m": 0.7}]}
    world = drawn(tmp_path, walls=[wall], start={"at_m": [-1, 0]}, goal={"box": {"center_m": [1, 2], "size_m": [1, 1]}})
    assert clearance_m(world, 0.0, 1.5) == pytest.approx(0.35)
    assert clearance_m(world, 0.0, 1.1) == 0.0
    assert clearance_m(world, 0.0, 1.9) == 0.0


def test_doors_cut_a_line_where_they_are() -> None:
    line = np.array([[0.0, 0], [2, 0], [2, 2]])
    parts = cut(line, [(2.5, 3.0), (0.5, 1.0), (2.7, 3.2), (3.9, 5.0), (-1.0, 0.1)])
    assert [part.tolist() for part in parts] == [
        [[0.1, 0.0], [0.5, 0.0]],
        [[1.0, 0.0], [2.0, 0.0], [2.0, 0.5]],
        [[2.0, pytest.approx(1.2)], [2.0, pytest.approx(1.9)]],
    ]


def test_a_room_may_have_a_door(tmp_path: Path) -> None:
    room = {"along": [[0, 0], [4, 0], [4, 3], [0, 3]], "closed": True, "doors": [{"at_m": 12.5, "width_m": 0.8}]}
    world = drawn(
        tmp_path, walls=[room], start={"at_m": [2, 1]}, goal={"circle": {"center_m": [-1, 1.5], "radius_m": 0.3}}
    )
    assert clearance_m(world, 0.0, 1.5) == pytest.approx(0.4)
    assert world.shortest_m == pytest.approx(3.0, abs=0.4)


def test_a_draw_that_crosses_itself_is_drawn_again(tmp_path: Path) -> None:
    """In many draws of this zigzag the corridor runs into itself: no seed is an error for that."""
    keys = {**ZIGZAG, "corners": 3, "corner_deg": [20, 135], "straight_m": [0.5, 3], "half_width_m": [0.3, 0.9]}
    keys |= {"dead_ends": [0, 3]}
    for seed in range(20):
        world = drawn(tmp_path, seed, zigzag=keys)
        (loop,) = (body.outline for body in world.draw.bodies)
        assert len(loop) >= 6
        assert Passage(world.draw.bodies, world.draw.start, world.draw.goal_m).leads_to_goal(RADIUS_M)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"zigzag": {**ZIGZAG, "straight_m": 0.5, "dead_ends": 2}}, "the zigzag crosses itself"),
        ({"ring": {**RING, "radius_m": 0.65}}, "the ring is wider than its corners"),
        ({"ring": {**RING, "radius_m": 3.5}}, "the corners of the ring are rounder than it is long or wide"),
        ({"ring": RING, "zigzag": ZIGZAG}, "a map has 'zigzag' and 'ring'"),
    ],
)
def test_what_cannot_be_a_corridor_is_refused(tmp_path: Path, keys: dict[str, Any], said: str) -> None:
    with pytest.raises(UserError, match=said):
        drawn(tmp_path, **keys)
