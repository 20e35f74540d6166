"""Pictures by sixels."""

from __future__ import annotations

from collections.abc import Callable

from textual.strip import Strip

from graphnav.arrays import Bytes
from graphnav.watch.spy.graphics.sixel import SCALES, sixels
from graphnav.watch.spy.screen.painters.painter import Cells, centred
from graphnav.watch.spy.screen.painters.raw_strips import raw_strips

_MAX_PX = 100_000
"""A larger picture would need more than a tenth of a core at 5 Hz: its pixels then cover several dots each."""
_MAX_DOTS = 1000
"""By default xterm does not draw beyond this number of rows or columns of dots."""


class SixelPainter:
    """``cell_px`` returns the dots of a cell, which may change while the terminal is open."""

    is_raw = True

    def __init__(self, cell_px: Callable[[], tuple[int, int]], n_colours: int) -> None:
        self._cell_px = cell_px
        self._n_colours = n_colours

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the maximum size that is drawn in time, in pixels of one or several dots."""
        scale, n_rows, n_cols = self._box(rows, cols)
        return max(1, n_rows // scale), max(1, n_cols // scale)

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines of the view; partially covered cells at the edge are blanked."""
        cells = self.place(picture, rows, cols)
        scale, (cell_rows, cell_cols) = self._box(rows, cols)[0], self._cell_px()
        covered = cells._replace(rows=picture.shape[0] * scale // cell_rows, cols=picture.shape[1] * scale // cell_cols)
        return raw_strips(rows, cols, cells, covered, sixels(picture, scale, self._n_colours))

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells that the picture covers at least partially."""
        scale, (cell_rows, cell_cols) = self._box(rows, cols)[0], self._cell_px()
        return centred(-(-picture.shape[0] * scale // cell_rows), -(-picture.shape[1] * scale // cell_cols), rows, cols)

    def erase(self) -> str:
        """Return an empty sequence: writing over a picture replaces it."""
        return ""

    def _box(self, rows: int, cols: int) -> tuple[int, int, int]:
        """Return the dots per pixel, and the rows and columns of dots of a view."""
        cell_rows, cell_cols = self._cell_px()
        n_rows, n_cols = min(rows * cell_rows, _MAX_DOTS), min(cols * cell_cols, _MAX_DOTS)
        fitting = (scale for scale in SCALES if (n_rows // scale) * (n_cols // scale) <= _MAX_PX)
        return next(fitting, SCALES[-1]), n_rows, n_cols
