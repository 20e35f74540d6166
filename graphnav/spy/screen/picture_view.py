"""A picture in the terminal."""

from __future__ import annotations

import numpy as np
from rich.segment import Segment
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from graphnav.arrays import Bytes
from graphnav.spy.screen.painters.painter import Cells, Painter


class PictureView(Widget):
    """Shows a picture in its middle, or why there is none."""

    def __init__(self, painter: Painter, *, id: str | None = None) -> None:  # noqa: A002, Textual's name
        super().__init__(id=id)
        self._painter = painter
        self._strips: list[Strip] = []
        self.picture: Bytes | None = None
        """What is shown; None where a text is, or nothing."""
        self._painted_for = self.size
        self._is_lost = False

    @property
    def box_px(self) -> tuple[int, int]:
        """Rows and columns of pixels that there is room for."""
        return self._painter.box_px(self.size.height, self.size.width)

    @property
    def wants_picture(self) -> bool:
        """Whether there is room for a picture that was not shown, or was taken away, before the layout was done."""
        return self._is_lost and self.display and bool(self.size)

    @property
    def has_small_pixels(self) -> bool:
        """Whether pixels are so small that letters can be read."""
        return self._painter.is_raw

    @property
    def is_raw(self) -> bool:
        """Whether the lines hold a picture as escape sequences, so that its pixels are not in the cells."""
        return self._painter.is_raw and self.picture is not None

    @property
    def place(self) -> Cells | None:
        """The cells that the picture takes."""
        return None if self.picture is None else self._painter.place(self.picture, self.size.height, self.size.width)

    def show(self, picture: Bytes) -> None:
        """Show a picture (rows, cols, 3) that fits the box; the one that is shown costs nothing."""
        shown = self.picture if self._painted_for == self.size else None
        self._is_lost = not self.size
        if self._is_lost or (shown is not None and np.array_equal(shown, picture)):
            return
        self.picture, self._painted_for = picture, self.size
        self._strips = self._painter.paint(picture, self.size.height, self.size.width)
        self.refresh()

    def say(self, text: str) -> None:
        """Show a text in place of a picture."""
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
        """Return lines; those with escape sequences as they are."""
        if not self.is_raw:
            return super().render_lines(crop)
        if self._painted_for != self.size:
            return [Strip.blank(crop.width)] * crop.height
        return self._strips[crop.y : crop.bottom]

    def on_resize(self) -> None:
        """Show nothing until there is a picture of the new size."""
        if self.picture is not None and self._painted_for != self.size:
            self.take_away()
            self.refresh()

    def on_hide(self) -> None:
        """Take the picture off the screen; it may be to be seen again by now."""
        if not self.display:
            self.take_away()

    def on_unmount(self) -> None:
        """Take the picture off the screen."""
        self.take_away()

    def take_away(self) -> None:
        """Take the picture off the screen, or the text."""
        self._is_lost = self.picture is not None
        self.picture, self._strips = None, []
        driver = self.app._driver  # noqa: SLF001, Textual has no other way to write what is not a cell
        if driver is not None and (sequence := self._painter.erase()):
            driver.write(sequence)
