"""The columns of the table with their cells, and the selection that fits a terminal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.cells import cell_len, set_cell_size

from graphnav.core.errors import shown_name
from graphnav.watch.spy.row import Row
from graphnav.watch.spy.traffic_report import size_of

_BARS = "▁▂▃▄▅▆▇█"
GAP = 1
_MAX_NAME, _MAX_SPARK = 40, 60
_MAX_COUNT = 10**7
_BEFORE_BARS = 2
"""Columns beside the name that matter more than the bars."""


def sparkline(counts: Sequence[int], width: int) -> str:
    """Return the newest ``width`` counts as bars from the right, the maximum as a full bar, 0 as a space."""
    newest = list(counts)[-width:] if width > 0 else []
    highest = max(newest, default=0)
    bars = [_BARS[-(-count * len(_BARS) // highest) - 1] if count else " " for count in newest]
    return "".join(bars).rjust(width)


@dataclass(frozen=True)
class Column:
    """A column: its string for a row, and its sort key."""

    heading: str
    width: int
    text: Callable[[Row], str]
    key: Callable[[Row], Any]
    is_left: bool = False

    def cell(self, row: Row, width: int) -> str:
        """Return the column's cell of a line."""
        return fitted(self.text(row), width, is_left=self.is_left)


class Bars(Column):
    """The column of rate bars, the newest at its right end."""

    def cell(self, row: Row, width: int) -> str:
        """Return the newest bars that fit."""
        return sparkline(row.counts, width)


def fitted(text: str, width: int, *, is_left: bool) -> str:
    """Return a string as exactly ``width`` cells, cut with an ellipsis if it is longer."""
    length = cell_len(text)
    if length > width:
        return set_cell_size(text, max(width - 1, 0)) + "…"[:width]
    return text + " " * (width - length) if is_left else " " * (width - length) + text


def _number(value: float | None, digits: int = 1) -> str:
    """Format a number with about four significant digits, None as a dash."""
    if value is None:
        return "-"
    return f"{value:.{digits}f}" if abs(value) < 1e5 else f"{value:.3g}"


def _ms(value: float | None) -> str:
    return _number(None if value is None else value * 1e3)


def age_text(age_s: float | None) -> str:
    """Format an age: tenths of seconds below a minute, then minutes, then hours."""
    if age_s is None:
        return "-"
    if age_s < 59.95:
        return f"{age_s:.1f} s"
    return f"{age_s / 60:.0f} min" if age_s < 5970 else f"{age_s / 3600:.0f} h"


def _low(value: float | None) -> float:
    """Return a sort key by which unknown numbers are below all others."""
    return -1e300 if value is None else value


def _rate(row: Row) -> str:
    return "-" if row.rate_hz is None else f"{_number(row.rate_hz, 2 if row.rate_hz < 1000 else 0)} Hz"


def _size(row: Row) -> str:
    return "-" if row.n_bytes is None else size_of(row.n_bytes)


def _bandwidth(row: Row) -> str:
    return "-" if row.bytes_per_s is None else f"{size_of(round(row.bytes_per_s))}/s"


def _count(value: int) -> str:
    """Format a count, 0 as a dash; a count that does not fit is rounded."""
    if not value:
        return "-"
    return str(value) if value < _MAX_COUNT else f"{value:.1e}"


NAME = Column("channel", 22, lambda row: shown_name(row.name), lambda row: row.name, is_left=True)
SPARK = Bars("per second", 10, lambda row: str(sum(row.counts)), lambda row: sum(row.counts))
_BY_PRIORITY = (
    Column("rate", 11, _rate, lambda row: _low(row.rate_hz)),
    Column("size", 9, _size, lambda row: _low(row.n_bytes)),
    Column("drops", 7, lambda row: _count(row.drops), lambda row: row.drops),
    Column("age", 7, lambda row: age_text(row.age_s), lambda row: _low(row.age_s)),
    Column("messages", 9, lambda row: str(row.messages), lambda row: row.messages),
    Column("undec.", 7, lambda row: _count(row.undecodable), lambda row: row.undecodable),
    Column(
        "type",
        26,
        lambda row: shown_name(row.type_name or "unknown type"),
        lambda row: row.type_name or "",
        is_left=True,
    ),
    Column("bandwidth", 11, _bandwidth, lambda row: _low(row.bytes_per_s)),
    Column("transport ms", 12, lambda row: _ms(row.transport_s), lambda row: _low(row.transport_s)),
    Column("mean ms", 8, lambda row: _ms(row.mean_s), lambda row: _low(row.mean_s)),
    Column("std ms", 8, lambda row: _ms(row.std_s), lambda row: _low(row.std_s)),
    Column("min ms", 8, lambda row: _ms(row.min_s), lambda row: _low(row.min_s)),
    Column("max ms", 8, lambda row: _ms(row.max_s), lambda row: _low(row.max_s)),
)
_IN_ORDER = ("type", "messages", "rate", "min ms", "mean ms", "max ms", "std ms", "bandwidth", "size", "transport ms")
_ORDER = {heading: place for place, heading in enumerate((*_IN_ORDER, "drops", "undec.", "age"))}


def layout(width: int) -> list[tuple[Column, int]]:
    """Return the columns that fit ``width`` cells with their widths, from left to right.

    The name is always shown, the bars beside two other columns at least; they share the remaining width.
    """
    few = sum(column.width + GAP for column in _BY_PRIORITY[:_BEFORE_BARS])
    has_bars = width >= NAME.width + few + GAP + SPARK.width
    left = width - NAME.width - (GAP + SPARK.width) * has_bars
    shown = []
    for column in _BY_PRIORITY:
        if left < column.width + GAP:
            break
        left -= column.width + GAP
        shown.append(column)
    shown.sort(key=lambda column: _ORDER[column.heading])
    middle = [(column, column.width) for column in shown]
    if not has_bars:
        return [(NAME, NAME.width + left), *middle]
    for_name = max(0, min(left // 2, _MAX_NAME - NAME.width))
    for_spark = max(0, min(left - for_name, _MAX_SPARK - SPARK.width))
    return [(NAME, NAME.width + for_name), *middle, (SPARK, SPARK.width + for_spark)]
