"""Maps that would take much memory or time, or enclose nothing, are refused at their place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_world.geometry import outlines
from graphnav_world.maps import world_map
from graphnav_world.maps.effort import MAX_STEPS, Effort
from graphnav_world.maps.passage import MAX_CELLS, Passage
from graphnav_world.maps.pillars import spread
from graphnav_world.maps.world_map import load_map

from graphnav import UserError
from graphnav.arrays import Doubles

START = "start: {at_m: [0, 0]}\n"


def refusal(tmp_path: Path, text: str) -> str:
    (tmp_path / "map.yaml").write_text(START + text)
    with pytest.raises(UserError) as refused:
        load_map(tmp_path / "map.yaml", 0, 0.2)
    return str(refused.value)


def test_arcs_of_too_many_points_are_refused(tmp_path: Path) -> None:
    arc = "{arc: {center_m: [0, 0], radius_m: 1000, from_deg: -3600, to_deg: 3600}}"
    said = refusal(tmp_path, f"walls: [{{along: [{', '.join([arc] * 900)}]}}]\n")
    column = len("walls: [{along: [") + arc.index(" 3600") + 2
    assert f"map.yaml:2:{column}: the arcs up to this one have 31417 points" in said


def test_polygons_of_too_many_corners_are_refused(tmp_path: Path) -> None:
    points = ", ".join(f"[{x}, {y}]" for x in range(20) for y in range(100))
    said = refusal(tmp_path, f"obstacles: [{{polygon: {{points_m: [{points}]}}}}]\n")
    assert "map.yaml:2:34: this polygon has 2000 corners, but may have 500" in said


@pytest.mark.parametrize("points", ["[2, 2], [4, 4], [4, 2], [2, 4]", "[2, 2], [6, 2], [6, 4], [4, 1], [2, 4]"])
def test_a_closed_wall_that_crosses_itself_is_refused(points: str, tmp_path: Path) -> None:
    said = refusal(tmp_path, f"walls: [{{along: [{points}], closed: true}}]\n")
    assert "map.yaml:2:17: this closed wall crosses itself" in said


@pytest.mark.parametrize(
    "text",
    [
        "textures: {floor: {mean: 1e308}}",
        "textures: {floor: {grain_m: 1e-300}}",
        "textures: {floor: {tile_m: 1e308}}",
        "view: {light_ratio: 1e308}",
        "obstacles: [{circle: {center_m: [5, 5], radius_m: 1}, moves: {through_m: [[6, 6]], speed_mps: 1e300}}]",
    ],
)
def test_numbers_without_sense_are_refused_at_their_place(text: str, tmp_path: Path) -> None:
    place, *_ = (at for at in (text.find("1e308"), text.find("1e-300"), text.find("1e300")) if at >= 0)
    assert refusal(tmp_path, text).split(" ")[0] == f"{tmp_path / 'map.yaml'}:2:{place + 1}:"


@pytest.mark.parametrize("count", ["[60, 70]", "300"])
def test_pillars_that_cannot_be_placed_are_refused(count: str, tmp_path: Path) -> None:
    field = "field: {corner_m: [1, 1], size_m: [8, 6]}"
    said = refusal(tmp_path, f"pillars: {{count: {count}, radius_m: [0.1, 0.25], gap_m: 0.8, {field}}}\n")
    assert "map.yaml:2:18: " in said
    assert "pillars with gaps of 0.8 m cannot be placed in the field" in said


def test_pillars_are_placed_with_no_more_than_the_effort_that_is_left() -> None:
    radii, size_m = np.full(40, 0.2), np.array([8.0, 6.0])
    full, little = Effort(), Effort(20_000)
    assert spread(radii, 0.8, size_m, np.random.default_rng(0), full) is not None
    assert not full.is_spent
    assert spread(radii, 0.8, size_m, np.random.default_rng(0), little) is None
    assert little.is_spent


def test_a_map_that_does_not_fit_is_drawn_again_until_its_effort_is_spent(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    grids = []

    class Counted(Passage):
        def __init__(self, *args: Any) -> None:
            super().__init__(*args)
            grids.append(self.n_cells)

    monkeypatch.setattr(world_map, "Passage", Counted)
    wall = "walls: [{along: [[-2, -2], [14, -2], [14, 8], [-2, 8]], closed: true}]\n"
    goal = "goal: {circle: {center_m: [[20, 21], 0], radius_m: 0.5}}\n"
    assert "map.yaml:2:7: no path leads from the start to the goal" in refusal(tmp_path, goal + wall)
    assert 10 < len(grids) < world_map.ATTEMPTS
    assert sum(grids) < 1.2 * MAX_STEPS


def test_what_did_not_fit_is_told_also_if_the_effort_ends_while_pillars_are_placed(tmp_path: Path) -> None:
    pillars = "pillars: {count: 90, radius_m: 0.2, gap_m: 0.8, field: {corner_m: [2, 2], size_m: [14, 11]}}\n"
    wall = "walls: [{along: [[-1, -1], [1, -1], [1, 1], [-1, 1]], closed: true}]\n"
    said = refusal(tmp_path, "goal: {circle: {center_m: [20, 0], radius_m: 0.5}}\n" + wall + pillars)
    assert "map.yaml:2:7: no path leads from the start to the goal" in said


def test_the_grid_of_a_large_map_is_coarser(tmp_path: Path) -> None:
    square = "walls: [{along: [[-1, -1], [97, -1], [97, 97], [-1, 97]], closed: true}]\n"
    (tmp_path / "map.yaml").write_text(START + "goal: {circle: {center_m: [96, 96], radius_m: 0.5}}\n" + square)
    found = load_map(tmp_path / "map.yaml", 0, 0.2)
    assert found.shortest_m == pytest.approx(96 * np.sqrt(2) - 0.5, abs=0.3)
    assert Passage(found.draw.bodies, found.draw.start, found.draw.goal_m).n_cells < 1.01 * MAX_CELLS


def test_crossing_agrees_with_a_search_over_all_pairs() -> None:
    rng = np.random.default_rng(7)
    found = []
    for _ in range(200):
        outline = rng.integers(0, 6, (int(rng.integers(3, 8)), 2)).astype(float)
        found.append(outlines.crosses_itself(outline))
        assert found[-1] == _touch_somewhere(outline)
    assert 20 < sum(found) < 180


def _touch_somewhere(outline: Doubles) -> bool:
    """Return whether two sides that are not adjacent touch, by exact integer arithmetic."""
    corners = [tuple(map(int, corner)) for corner in outline]
    n = len(corners)
    sides = [(corners[i], corners[(i + 1) % n]) for i in range(n)]
    pairs = [(i, j) for i in range(n) for j in range(i + 2, n) if (i, j) != (0, n - 1)]
    return any(_touch(*sides[i], *sides[j]) for i, j in pairs)


def _touch(a: tuple[int, ...], b: tuple[int, ...], c: tuple[int, ...], d: tuple[int, ...]) -> bool:
    turns = [(q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) for p, q, r in
             ((a, b, c), (a, b, d), (c, d, a), (c, d, b))]  # fmt: skip
    if not any(turns):
        near = (min(a[k], b[k]) <= max(c[k], d[k]) and min(c[k], d[k]) <= max(a[k], b[k]) for k in (0, 1))
        return all(near)
    return turns[0] * turns[1] <= 0 and turns[2] * turns[3] <= 0
