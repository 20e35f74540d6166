"""The screen of all channels."""

from __future__ import annotations

from typing import ClassVar

from textual import on
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.screen import Screen
from textual.widgets import Footer, Input, Static

from graphnav.watch.spy.screen.channel_screen import ChannelScreen
from graphnav.watch.spy.screen.channel_table import ChannelTable
from graphnav.watch.spy.screen.keys_screen import is_shown
from graphnav.watch.spy.screen.reason_line import ReasonLine
from graphnav.watch.spy.screen.session import Session

_TABLE_S = 0.5
"""The interval of the table's updates."""


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
