"""The screen of all channels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rich.segment import Segment
from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import Screen
from textual.widgets import Footer, Input, Static

from graphnav.watch.spy.row import Row
from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.columns import GAP, NAME, Column, fitted, layout
from graphnav.watch.spy.screen.keys_screen import is_shown
from graphnav.watch.spy.screen.line_list import HEADING, PLAIN, QUIET, WARNING, Line, Lines
from graphnav.watch.spy.screen.reason_line import ReasonLine
from graphnav.watch.spy.screen.session import Session

_WARNED = {"drops", "undec."}
_TABLE_S = 0.5
"""The interval of the table's updates."""


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


class ChannelsScreen(Screen[None]):
    """Heading, table and filter."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("enter", "open", "open", tooltip="open the channel at the cursor"),
        Binding("slash", "filter", "filter", key_display="/", tooltip="show only names and types that contain a word"),
        Binding("escape", "clear_filter", "all", show=False, tooltip="show all channels"),
        Binding("s", "sort", "sort", tooltip="sort by the next column"),
        Binding("S", "reverse", "reverse", show=False, key_display="S", tooltip="reverse the order"),
    ]

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session

    def compose(self) -> ComposeResult:
        """Lay out the screen."""
        yield Static(id="heading", markup=False)
        yield ReasonLine()
        yield ChannelTable(id="table")
        yield Input(placeholder="part of a channel's name or type", id="filter")
        yield Footer()

    def on_mount(self) -> None:
        """Begin to refresh."""
        self.query_one("#filter").display = False
        self.set_focus(self.query_one("#table"))
        self.set_interval(_TABLE_S, self.show)
        self.call_after_refresh(self.show)

    def on_screen_resume(self) -> None:
        """Show the changes since a channel was opened."""
        self.show()

    def show(self) -> None:
        """Update table and heading, unless the view is frozen or hidden."""
        if not is_shown(self):
            return
        watch, table = self._session.watch, self.query_one(ChannelTable)
        self.query_one("#heading", Static).update(self._session.heading(), layout=False)
        if self._session.is_frozen:
            return
        rows = watch.rows()
        table.show(rows)
        reason = watch.why_empty(None)
        if not reason and rows and not table.n_shown:
            reason = f"no name or type of {len(rows)} channels contains '{table.pattern}': Esc shows all"
        self.query_one(ReasonLine).say(reason)

    def action_open(self) -> None:
        """Open the channel at the cursor."""
        name = self.query_one(ChannelTable).chosen
        if name is not None:
            self.app.push_screen(ChannelScreen(name, self._session))

    @on(ChannelTable.Chosen)
    def _open(self) -> None:
        self.action_open()

    def action_filter(self) -> None:
        """Ask for a pattern."""
        field = self.query_one("#filter", Input)
        field.display = True
        self.set_focus(field)

    def action_clear_filter(self) -> None:
        """Show all channels."""
        field = self.query_one("#filter", Input)
        field.value = ""
        field.display = False
        self.set_focus(self.query_one(ChannelTable))

    @on(Input.Changed, "#filter")
    def _filter(self, event: Input.Changed) -> None:
        self.query_one(ChannelTable).filter_by(event.value)
        self.show()

    @on(Input.Submitted, "#filter")
    def _keep_filter(self) -> None:
        self.set_focus(self.query_one(ChannelTable))

    def action_sort(self) -> None:
        """Sort by the next column."""
        self.query_one(ChannelTable).sort_by_next()

    def action_reverse(self) -> None:
        """Turn the order around."""
        self.query_one(ChannelTable).reverse()
