"""A widget for a picture."""

from __future__ import annotations

import numpy as np
from rich.segment import Segment
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from graphnav.arrays import Bytes
from graphnav.watch.spy.screen.painters.painter import Cells, Painter


class PictureView(Widget):
    """Shows a picture in its centre, or a message."""

    def __init__(self, painter: Painter, *, id: str | None = None) -> None:  # noqa: A002, Textual's name
        super().__init__(id=id)
        self._painter = painter
        self._strips: list[Strip] = []
        self.picture: Bytes | None = None
        """The displayed picture; None if a message is shown, or nothing."""
        self._painted_for = self.size
        self._is_lost = False

    @property
    def box_px(self) -> tuple[int, int]:
        """Rows and columns of pixels that fit."""
        return self._painter.box_px(self.size.height, self.size.width)

    @property
    def wants_picture(self) -> bool:
        """Whether a picture fits now that was not shown, or was removed, before the layout."""
        return self._is_lost and self.display and bool(self.size)

    @property
    def has_small_pixels(self) -> bool:
        """Whether pixels are small enough for legible text."""
        return self._painter.is_raw

    @property
    def is_raw(self) -> bool:
        """Whether the lines hold a picture as escape sequences instead of cells."""
        return self._painter.is_raw and self.picture is not None

    @property
    def place(self) -> Cells | None:
        """The cells of the picture."""
        return None if self.picture is None else self._painter.place(self.picture, self.size.height, self.size.width)

    def show(self, picture: Bytes) -> None:
        """Show a picture (rows, cols, 3) that fits the box; free for the displayed picture."""
        shown = self.picture if self._painted_for == self.size else None
        self._is_lost = not self.size
        if self._is_lost or (shown is not None and np.array_equal(shown, picture)):
            return
        self.picture, self._painted_for = picture, self.size
        self._strips = self._painter.paint(picture, self.size.height, self.size.width)
        self.refresh()

    def say(self, text: str) -> None:
        """Show a message in place of a picture."""
        strips = [Strip([Segment(line)]) for line in text.splitlines()]
        if self.picture is not None or strips != self._strips:
            self.take_away()
            self._strips = strips
            self.refresh()
        self._is_lost = False

    def render_line(self, y: int) -> Strip:
        """Return a line of the picture."""
        return self._strips[y] if y < len(self._strips) else Strip([])

    def render_lines(self, crop: Region) -> list[Strip]:
        """Return lines; those with escape sequences unchanged."""
        if not self.is_raw:
            return super().render_lines(crop)
        if self._painted_for != self.size:
            return [Strip.blank(crop.width)] * crop.height
        return self._strips[crop.y : crop.bottom]

    def on_resize(self) -> None:
        """Clear the view until there is a picture of the new size."""
        if self.picture is not None and self._painted_for != self.size:
            self.take_away()
            self.refresh()

    def on_hide(self) -> None:
        """Remove the picture from the screen, unless it is visible again."""
        if not self.display:
            self.take_away()

    def on_unmount(self) -> None:
        """Remove the picture from the screen."""
        self.take_away()

    def take_away(self) -> None:
        """Remove the picture or the message from the screen."""
        self._is_lost = self.picture is not None
        self.picture, self._strips = None, []
        driver = self.app._driver  # noqa: SLF001, Textual has no other way to write what is not a cell
        if driver is not None and (sequence := self._painter.erase()):
            driver.write(sequence)
