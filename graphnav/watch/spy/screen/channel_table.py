"""The table of channels."""

from __future__ import annotations

from collections.abc import Sequence

from rich.segment import Segment

from graphnav.watch.spy.screen.columns import GAP, NAME, Column, fitted, layout
from graphnav.watch.spy.screen.line_list import HEADING, PLAIN, QUIET, WARNING, Line, Lines
from graphnav.watch.spy.watch.row import Row

_WARNED = {"drops", "undec."}


class ChannelTable(Lines):
    """One line per channel; the cursor stays on its channel while lines are added, removed and sorted."""

    def __init__(self, *, id: str | None = None) -> None:  # noqa: A002, Textual's name
        super().__init__(id=id)
        self._rows: Sequence[Row] = ()
        self._names: list[str] = []
        self.pattern = ""
        self.sort_by: Column = NAME
        self.is_reversed = False

    @property
    def chosen(self) -> str | None:
        """The channel at the cursor."""
        return self._names[self.cursor] if self.cursor < len(self._names) else None

    @property
    def n_shown(self) -> int:
        """The number of channels that pass the filter."""
        return len(self._names)

    def show(self, rows: Sequence[Row]) -> None:
        """Show channels."""
        self._rows = rows
        self._draw(self.chosen)

    def filter_by(self, pattern: str) -> None:
        """Show the channels whose name or type contains a pattern, ignoring case."""
        self.pattern = pattern.casefold()
        self._draw(self.chosen)

    def sort_by_next(self) -> None:
        """Sort by the next column, from the left."""
        columns = [column for column, _ in layout(self.size.width)]
        place = columns.index(self.sort_by) if self.sort_by in columns else -1
        self.sort_by = columns[(place + 1) % len(columns)]
        self.is_reversed = self.sort_by is not NAME
        self._draw(self.chosen)

    def reverse(self) -> None:
        """Reverse the order."""
        self.is_reversed = not self.is_reversed
        self._draw(self.chosen)

    def on_resize(self) -> None:
        """Show the columns that fit."""
        self._draw(self.chosen)

    def _draw(self, chosen: str | None) -> None:
        rows = [row for row in self._rows if self._lets_through(row)]
        rows.sort(key=NAME.key)
        rows.sort(key=self.sort_by.key, reverse=self.is_reversed)
        self._names = [row.name for row in rows]
        columns = layout(self.size.width)
        cursor = self._names.index(chosen) if chosen in self._names else min(self.cursor, max(0, len(rows) - 1))
        self.show_lines(self._headings(columns), [_line(row, columns) for row in rows], cursor)

    def _lets_through(self, row: Row) -> bool:
        return self.pattern in row.name.casefold() or self.pattern in (row.type_name or "").casefold()

    def _headings(self, columns: Sequence[tuple[Column, int]]) -> Line:
        arrow = "▼" if self.is_reversed else "▲"
        texts = [
            fitted(column.heading + (arrow if column is self.sort_by else ""), width, is_left=column.is_left)
            for column, width in columns
        ]
        return [Segment((" " * GAP).join(texts), HEADING)]


def _line(row: Row, columns: Sequence[tuple[Column, int]]) -> Line:
    """Return a channel's line: dim where it is stale, warnings in colour."""
    style = QUIET if row.is_stale or not row.messages else PLAIN
    line: Line = []
    for column, width in columns:
        cell = column.cell(row, width) + " " * GAP
        is_warning = column.heading in _WARNED and cell.strip() != "-"
        line.append(Segment(cell, WARNING if is_warning else style))
    return line
