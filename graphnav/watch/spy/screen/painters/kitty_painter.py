"""Pictures by the graphics protocol of kitty."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable

from textual.strip import Strip

from graphnav.arrays import Bytes
from graphnav.watch.spy.graphics.kitty import delete, put
from graphnav.watch.spy.screen.painters.painter import Cells, centred
from graphnav.watch.spy.screen.painters.raw_strips import raw_strips

_MAX_PX = 150_000
"""The maximum number of pixels; in a larger view the terminal scales the picture up."""
_NOTHING = Cells(0, 0, 0, 0)
_IDS = itertools.count(os.getpid() << 8)
"""Two ids per view, so that a closed view does not delete the picture of the next one."""


class KittyPainter:
    """Draws the next picture over the last one before deleting that one, to avoid flicker.

    ``cell_px`` returns the pixels of a cell, for the picture's proportions.
    """

    is_raw = True

    def __init__(self, cell_px: Callable[[], tuple[int, int]]) -> None:
        self._cell_px = cell_px
        self._next_id, self._other_id = next(_IDS), next(_IDS)
        self._shown_id = 0

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the maximum size to send."""
        cell_rows, cell_cols = self._cell_px()
        ratio = self._ratio(rows, cols)
        return max(1, math.floor(rows * cell_rows * ratio)), max(1, math.floor(cols * cell_cols * ratio))

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines of the view, blank below the picture."""
        cells = self.place(picture, rows, cols)
        image_id, old_id = self._next_id, self._shown_id
        self._next_id, self._other_id, self._shown_id = self._other_id, image_id, image_id
        sequence = put(picture, image_id, cells.rows, cells.cols) + (delete(old_id) if old_id else "")
        return raw_strips(rows, cols, cells, _NOTHING, sequence)

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells that the picture is scaled to."""
        cell_rows, cell_cols = self._cell_px()
        ratio = self._ratio(rows, cols)
        n_rows, n_cols = round(picture.shape[0] / ratio / cell_rows), round(picture.shape[1] / ratio / cell_cols)
        return centred(min(max(1, n_rows), rows), min(max(1, n_cols), cols), rows, cols)

    def erase(self) -> str:
        """Return the sequence that deletes the picture, which text does not replace."""
        image_id, self._shown_id = self._shown_id, 0
        return delete(image_id) if image_id else ""

    def _ratio(self, rows: int, cols: int) -> float:
        """Return the ratio of sent pixels to pixels of the view, the same in both directions."""
        cell_rows, cell_cols = self._cell_px()
        return min(1.0, math.sqrt(_MAX_PX / max(1, rows * cell_rows * cols * cell_cols)))
