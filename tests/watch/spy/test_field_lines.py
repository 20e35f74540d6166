"""Fields as a tree: summarised, expandable, bounded."""

from __future__ import annotations

from typing import Any

import numpy as np

from graphnav.watch.feed import KEPT_MESSAGES, Received
from graphnav.watch.spy.screen.field_tree import field_lines
from graphnav.watch.spy.series import Series, numbers_of, path_text

VALUES: dict[str, Any] = {
    "utime": 5,
    "seq": 6,
    "theta_rad": 0.25,
    "force": np.array([0.5, -1.5]),
    "grid": np.arange(600, dtype=np.float32).reshape(100, 6),
    "names": ("a\x1b[2J", "b"),
    "stages": ({"name": "flow", "steps": 3}, {"name": "plane", "steps": 4}),
    "text": "x\x1b[31m",
    "empty": np.empty((0, 3)),
}


def shown(*opened: tuple[str | int, ...]) -> dict[str, str]:
    return {path_text(line.path): line.text for line in field_lines(VALUES, set(opened))}


def test_closed_a_message_has_a_line_for_each_field() -> None:
    lines = field_lines(VALUES, set())
    assert [line.name for line in lines] == list(VALUES)
    assert {line.name for line in lines if line.is_open is False} == {"force", "grid", "names", "stages"}
    assert {line.name for line in lines if line.is_number} == {"utime", "seq", "theta_rad"}
    assert shown()["grid"] == "float32 (100, 6)  0 to 599, mean 299.5"


def test_arrays_open_down_to_single_numbers() -> None:
    lines = shown(("grid",), ("grid", 3))
    assert lines["grid[3]"].startswith("float32 (6)")
    assert lines["grid[3][5]"] == "23"
    assert "grid[63]" in lines
    assert "grid[64]" not in lines
    assert "36 more" in lines.values()


def test_structs_and_strings_open_too() -> None:
    lines = shown(("stages",), ("stages", 1), ("names",))
    assert lines["stages[1].steps"] == "4"
    assert lines["names[1]"] == '"b"'


def test_nothing_shown_holds_a_control_character() -> None:
    opened = {("names",), ("stages",), ("stages", 0)}
    assert all((line.name + line.text).isprintable() for line in field_lines(VALUES, opened))


def test_a_message_of_any_size_has_a_bounded_number_of_lines() -> None:
    values = {f"field_{k}": tuple({"a": 1} for _ in range(100)) for k in range(200)}
    assert len(field_lines(values, {(name,) for name in values})) <= 4000


def test_numbers_to_plot_are_scalars_and_short_arrays() -> None:
    found = {path_text(path): number for path, number in numbers_of(VALUES).items()}
    assert found == {"theta_rad": 0.25, "force[0]": 0.5, "force[1]": -1.5, "stages[0].steps": 3, "stages[1].steps": 4}
    assert len(numbers_of({f"x{k}": k for k in range(1000)})) == 64
    assert numbers_of({"huge": 10**400}) == {}


def test_a_series_keeps_the_newest_and_leaves_out_what_is_not_finite() -> None:
    series = Series()
    series.add((Received("x", b"", float(k)), {"x": float("nan") if k % 2 else k}) for k in range(2000))
    points = series.points(("x",))
    assert len(points) == KEPT_MESSAGES // 2
    assert points[-1] == (1998.0, 1998.0)
    assert series.newest_s == 1999.0
