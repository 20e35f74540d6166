"""The table's columns: what fits, and every cell as wide as its column."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from graphnav.watch.spy.row import Row
from graphnav.watch.spy.screen.columns import GAP, age_text, fitted, layout

ROW = Row(
    "robot.image", "graphnav_lcm.image_t", 12, 10.0, 0.1, 0.1, 0.1, 0.0, 1e6, 19248, None, 3, 0, 0.04, False, (9,)
)


@pytest.mark.parametrize("width", range(10, 260))
def test_columns_fill_no_more_than_the_terminal(width: int) -> None:
    columns = layout(width)
    assert sum(width for _, width in columns) + GAP * (len(columns) - 1) <= width
    line = [column.cell(ROW, width) for column, width in columns]
    assert [cell_len(cell) for cell in line] == [width for _, width in columns]


def test_80_columns_hold_what_matters_most() -> None:
    assert [column.heading for column, _ in layout(80)] == ["channel", "rate", "size", "drops", "age", "per second"]


def test_a_narrow_terminal_keeps_the_name_and_then_the_rate() -> None:
    assert [(column.heading, width) for column, width in layout(40)] == [("channel", 28), ("rate", 11)]
    assert [column.heading for column, _ in layout(54)] == ["channel", "rate", "size", "drops"]
    assert [column.heading for column, _ in layout(30)] == ["channel"]


def test_a_wide_terminal_shows_everything() -> None:
    shown = [column.heading for column, _ in layout(200)]
    assert shown[:3] == ["channel", "type", "messages"]
    assert {"min ms", "mean ms", "max ms", "std ms", "bandwidth", "transport ms", "undec."} <= set(shown)


@given(st.text(), st.integers(0, 30), st.booleans())
def test_a_cell_is_as_wide_as_its_column(text: str, width: int, is_left: bool) -> None:
    from graphnav.core.errors import shown_name

    assert cell_len(fitted(shown_name(text), width, is_left=is_left)) == width


@pytest.mark.parametrize("drops", [0, 9, 9_999_999, 10_000_000, 2**62])
def test_a_count_is_never_cut(drops: int) -> None:
    for column, width in layout(80):
        assert "…" not in column.cell(replace(ROW, drops=drops), width)


@pytest.mark.parametrize(
    ("age_s", "text"),
    [(None, "-"), (0.04, "0.0 s"), (59.94, "59.9 s"), (59.96, "1 min"), (5969.0, "99 min"), (7200.0, "2 h")],
)
def test_ages(age_s: float | None, text: str) -> None:
    assert age_text(age_s) == text
