"""Maps that would take much memory or time, or enclose nothing, are refused at their place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from graphnav_world.geometry import outlines
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
    said = refusal(tmp_path, f"walls: [{{along: [{', '.join([arc] * 1500)}]}}]\n")
    column = len("walls: [{along: [") + arc.index(" 3600") + 2
    assert f"map.yaml:2:{column}: the arcs up to this one have 31417 points" in said


def test_polygons_of_too_many_corners_are_refused(tmp_path: Path) -> None:
    points = ", ".join(f"[{x}, {y}]" for x in range(50) for y in range(100))
    said = refusal(tmp_path, f"obstacles: [{{polygon: {{points_m: [{points}]}}}}]\n")
    assert "map.yaml:2:34: this polygon has 5000 corners, but may have 500" in said


@pytest.mark.parametrize("points", ["[2, 2], [4, 4], [4, 2], [2, 4]", "[2, 2], [6, 2], [6, 4], [4, 1], [2, 4]"])
def test_a_closed_wall_that_crosses_itself_is_refused(points: str, tmp_path: Path) -> None:
    said = refusal(tmp_path, f"walls: [{{along: [{points}], closed: true}}]\n")
    assert "map.yaml:2:17: this closed wall crosses itself" in said


@pytest.mark.parametrize(
    "text",
    [
        "textures: {floor: {mean: 1e308}}",
        "textures: {floor: {grain_m: 1e-300}}",
        "view: {light_ratio: 1e308}",
        "obstacles: [{circle: {center_m: [5, 5], radius_m: 1}, moves: {through_m: [[6, 6]], speed_mps: 1e300}}]",
    ],
)
def test_numbers_without_sense_are_refused_at_their_place(text: str, tmp_path: Path) -> None:
    place, *_ = (at for at in (text.find("1e308"), text.find("1e-300"), text.find("1e300")) if at >= 0)
    assert refusal(tmp_path, text).split(" ")[0] == f"{tmp_path / 'map.yaml'}:2:{place + 1}:"


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
