"""Maps: every problem is reported with its place; random draws follow from the seed alone.

To regenerate the golden files, and then read them::

    python tests/plugins/world/test_maps.py
"""

from __future__ import annotations

import contextlib
import copy
import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from graphnav_world.geometry import outlines
from graphnav_world.geometry.patrol import Patrol
from graphnav_world.geometry.scene import Kind
from graphnav_world.maps.passage import Passage
from graphnav_world.maps.world_map import WorldMap, load_map
from hypothesis import given, settings
from hypothesis import strategies as st

from graphnav import Problem, UserError

HERE = Path(__file__).parent
BROKEN = HERE / "broken_maps"
CASES = sorted(path.stem for path in BROKEN.glob("*.yaml"))
RADIUS_M = 0.2


def message_of(case: str) -> str:
    with pytest.raises(UserError) as caught:
        load_map(Path(f"{case}.yaml"), seed=0, robot_radius_m=RADIUS_M)
    return f"{caught.value}\n"


@pytest.mark.parametrize("case", CASES)
def test_refused_with_the_golden_message(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(BROKEN)
    assert message_of(case) == Path(f"{case}.txt").read_text(encoding="utf-8")


def test_every_text_has_its_map() -> None:
    assert sorted(path.stem for path in BROKEN.glob("*.txt")) == CASES


CROSSING = yaml.safe_load((HERE.parents[2] / "graphs/graphnav_graphs/maps/crossing.yaml").read_text())
STRANGE = [0, -1, 1e308, -1e9, 5e-324, 10**400, [1e300, 1e308], [3, 2], [], {}, None, "x", True]


def _parts(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ():
        yield (*path, key)
        yield from _parts(inner, (*path, key))


@given(st.sampled_from(list(_parts(CROSSING))), st.sampled_from(STRANGE))
@settings(max_examples=40)
def test_whatever_is_in_a_map_it_is_drawn_or_refused(
    tmp_path_factory: pytest.TempPathFactory, part: tuple[Any, ...], value: Any
) -> None:
    complete = inner = copy.deepcopy(CROSSING)
    for key in part[:-1]:
        inner = inner[key]
    inner[part[-1]] = value
    path = tmp_path_factory.getbasetemp() / "strange.yaml"
    path.write_text(yaml.safe_dump(complete))
    problems: list[Problem] = []
    try:
        load_map(path, 0, RADIUS_M)
    except UserError as error:
        problems = error.problems
    assert all(problem.place for problem in problems)


@pytest.mark.parametrize("name", ["corridor_ccw", "pillars", "approach", "crossing", "crowded", "movers"])
def test_a_seed_draws_one_world_and_another_seed_another(name: str, maps: Path) -> None:
    one, same, other = (_digest(load_map(maps / f"{name}.yaml", seed, RADIUS_M)) for seed in (5, 5, 6))
    assert one == same
    assert one != other


def test_a_draw_does_not_depend_on_draws_elsewhere(tmp_path: Path) -> None:
    text = "start: {{at_m: [0, {start}]}}\nobstacles:\n  - {{circle: {{center_m: [[2, 3], 0], radius_m: 0.2}}}}\n"
    path = tmp_path / "map.yaml"
    centers = []
    for start in ("0", "[-0.5, 0.5]"):
        path.write_text(text.format(start=start))
        centers.append(load_map(path, 3, RADIUS_M).draw.bodies[0].outline.mean(axis=0))
    assert (centers[0] == centers[1]).all()
    assert 2.0 < centers[0][0] < 3.0


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize(("name", "side"), [("corridor_ccw", 1), ("corridor_cw", -1)])
def test_corridors_bend_as_their_name_says(name: str, side: int, seed: int, maps: Path) -> None:
    world = load_map(maps / f"{name}.yaml", seed, RADIUS_M)
    draw = world.draw
    goal = draw.goal_m
    bend = np.arctan2(*(goal[1] - goal[0])[::-1]) * side % (2 * np.pi)
    assert np.pi / 2 <= bend <= np.pi
    width = np.linalg.norm(goal[3] - goal[0])
    assert 1.1 <= width <= 1.8
    for end in (goal[0] * 0.5 + goal[1] * 0.5, goal[2] * 0.5 + goal[3] * 0.5):
        beside = min(outlines.distance(part, *end) for part in draw.bodies[0].parts)
        assert beside < 0.01, "the goal spans the corridor from wall to wall"
    straight = outlines.distance(goal, *draw.start[:2])
    assert straight < world.shortest_m < 5.9 * np.pi + 5


@pytest.mark.parametrize("seed", range(8))
def test_pillars_stand_apart_block_the_straight_way_and_leave_one(seed: int, maps: Path) -> None:
    world = load_map(maps / "pillars.yaml", seed, RADIUS_M)
    pillars = [body for body in world.draw.bodies if body.kind == Kind.OBSTACLE]
    assert 20 <= len(pillars) <= 40
    centers = [body.outline.mean(axis=0) for body in pillars]
    radii = [np.linalg.norm(body.outline - center, axis=1).max() for body, center in zip(pillars, centers, strict=True)]
    assert min(radii) >= 0.1
    assert max(radii) <= 0.25
    gaps = [
        np.linalg.norm(a - b) - r - s for (a, r), (b, s) in itertools.combinations(zip(centers, radii, strict=True), 2)
    ]
    assert min(gaps) >= 0.8
    low, high = np.min(centers, axis=0) - max(radii), np.max(centers, axis=0) + max(radii)
    assert (low > -0.16).all()
    assert (high < (8.16, 6.16)).all()
    passage = Passage(world.draw.bodies, world.draw.start, world.draw.goal_m)
    assert passage.leads_to_goal(RADIUS_M + 0.1)
    assert passage.straight_is_blocked(RADIUS_M)


@pytest.mark.parametrize("seed", range(4))
def test_movers_cross_the_way_and_keep_clear_of_everything_else(seed: int, maps: Path) -> None:
    bodies = load_map(maps / "movers.yaml", seed, RADIUS_M).draw.bodies
    moving = [(body, body.course) for body in bodies if body.course is not None]
    standing = [part for body in bodies if body.course is None for part in body.parts]
    assert len(moving) == 8
    for time_s in np.arange(0.0, 60.0, 1.5):
        places = [np.array(course.at(time_s)) for _, course in moving]
        radii = [np.linalg.norm(body.outline, axis=1).max() for body, _ in moving]
        for (at, radius), (other, its) in itertools.combinations(zip(places, radii, strict=True), 2):
            assert np.linalg.norm(at - other) > radius + its
        for at, radius in zip(places, radii, strict=True):
            assert min(outlines.distance(part, *at) for part in standing) > radius
    assert all(np.ptp(course.through_m[:, 1]) > 1.0 for _, course in moving)


@pytest.mark.parametrize("seed", range(4))
def test_the_crowded_way_leads_between_the_blocks(seed: int, maps: Path) -> None:
    world = load_map(maps / "crowded.yaml", seed, RADIUS_M)
    assert 6.5 < world.shortest_m < 7.5, "around the blocks it would be less"


def test_the_shortest_path_goes_around_a_corner(tmp_path: Path) -> None:
    path = tmp_path / "map.yaml"
    path.write_text(
        "start: {at_m: [0, 0]}\n"
        "goal: {box: {center_m: [2.5, 0], size_m: [1, 1]}}\n"
        "obstacles: [{box: {center_m: [1, 0], size_m: [0.2, 1.6]}}]\n"
    )
    around = 2 * np.hypot(0.9, 1.0 - 0.0) + 0.2
    straight_after = np.hypot(0.9, 0.5) + 0.2 + np.hypot(0.9, 1.0)
    length = load_map(path, 0, RADIUS_M).shortest_m
    assert straight_after * 0.97 < length < around * 1.05


def test_a_concave_polygon_is_tiled_by_convex_parts() -> None:
    star = np.array([[0, 0], [2, 1], [4, 0], [3, 2], [4, 4], [2, 3], [0, 4], [1, 2]], np.float64)
    parts = outlines.convex_parts(star)
    assert sum(outlines.signed_area(part) for part in parts) == pytest.approx(outlines.signed_area(star))
    rng = np.random.default_rng(0)
    for x, y in rng.uniform(-0.5, 4.5, (200, 2)):
        assert outlines.contains(star, x, y) == any(outlines.contains(part, x, y) for part in parts)


def _digest(world: WorldMap) -> bytes:
    draw = world.draw
    arrays = [np.array(draw.start), draw.goal_m, *(body.outline for body in draw.bodies)]
    speeds = [body.course.ahead_m for body in draw.bodies if isinstance(body.course, Patrol)]
    return b"".join(array.tobytes() for array in arrays) + repr((draw.textures, draw.light_ratio, speeds)).encode()


def _write_texts() -> None:
    with contextlib.chdir(BROKEN):
        for case in CASES:
            Path(f"{case}.txt").write_text(message_of(case), encoding="utf-8")


if __name__ == "__main__":
    _write_texts()
