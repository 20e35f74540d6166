"""A list of lines with a cursor, the base of the table and of the tree of fields."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.binding import Binding, BindingType
from textual.message import Message
from textual.strip import Strip
from textual.widget import Widget

Line = list[Segment]

PLAIN = Style()
HEADING = Style(bold=True)
QUIET = Style(dim=True)
WARNING = Style(color="yellow")
CURSOR = Style(reverse=True)


class Lines(Widget, can_focus=True):
    """Lines of fixed height below a heading, drawn only while visible.

    One widget draws all cells: a widget or a cell object per cell costs ten times as much at every refresh.
    """

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("up,k", "move(-1)", "up", show=False),
        Binding("down,j", "move(1)", "down", show=False),
        Binding("pageup", "page(-1)", "page up", show=False),
        Binding("pagedown", "page(1)", "page down", show=False),
        Binding("home", "jump(0)", "first", show=False),
        Binding("end", "jump(-1)", "last", show=False),
    ]

    class Chosen(Message):
        """Posted when the line at the cursor is clicked or entered."""

        def __init__(self, index: int) -> None:
            self.index = index
            super().__init__()

    def __init__(self, *, id: str | None = None) -> None:  # noqa: A002, Textual's name
        super().__init__(id=id)
        self._heading: Line = []
        self._lines: Sequence[Line] = ()
        self._top = self.cursor = 0

    def show_lines(self, heading: Line, lines: Sequence[Line], cursor: int) -> None:
        """Replace the lines, with the cursor on one of them."""
        if heading == self._heading and lines == self._lines and cursor == self.cursor:
            return
        self._heading, self._lines = heading, lines
        self.cursor = cursor
        self._follow()
        self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return a line of the widget; the heading is the first."""
        if y == 0:
            return Strip(self._heading)
        index = self._top + y - 1
        if index >= len(self._lines):
            return Strip([])
        if index == self.cursor and self.has_focus:
            return Strip([Segment("".join(segment.text for segment in self._lines[index]), CURSOR)])
        return Strip(self._lines[index])

    def action_move(self, count: int) -> None:
        """Move the cursor by some lines."""
        self._put(self.cursor + count)

    def action_page(self, count: int) -> None:
        """Move the cursor by pages."""
        self._put(self.cursor + count * max(1, self._n_visible - 1))

    def action_jump(self, index: int) -> None:
        """Move the cursor to a line, from the end if negative."""
        self._put(index if index >= 0 else len(self._lines) + index)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Scroll down."""
        event.stop()
        self.action_move(3)

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Scroll up."""
        event.stop()
        self.action_move(-3)

    def on_click(self, event: events.Click) -> None:
        """Move the cursor to the line at the pointer; select the line if it has the cursor."""
        index = self._top + event.y - 1
        if event.y < 1 or index >= len(self._lines):
            return
        if index == self.cursor:
            self.post_message(self.Chosen(index))
        self._put(index)

    def on_resize(self) -> None:
        """Keep the cursor in view."""
        self._follow()

    @property
    def _n_visible(self) -> int:
        return max(1, self.size.height - 1)

    def _put(self, index: int) -> None:
        self.cursor = max(0, min(index, len(self._lines) - 1))
        self._follow()
        self.refresh()

    def _follow(self) -> None:
        """Scroll minimally to show the cursor, and not beyond the last line."""
        self._top = min(max(self._top, self.cursor - self._n_visible + 1), self.cursor)
        self._top = max(0, min(self._top, len(self._lines) - self._n_visible))
