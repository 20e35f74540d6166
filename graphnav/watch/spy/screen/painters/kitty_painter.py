"""Pictures by the graphics protocol of kitty."""

from __future__ import annotations

import base64
import itertools
import math
import os
import zlib
from collections.abc import Callable

from textual.strip import Strip

from graphnav.arrays import Bytes
from graphnav.watch.spy.screen.painters.painter import Cells, centred, raw_strips

_CHUNK = 4096
"""The protocol's limit for the characters of one sequence."""
_FAST = 1
_MAX_PX = 150_000
"""The maximum number of pixels; in a larger view the terminal scales the picture up."""
_NOTHING = Cells(0, 0, 0, 0)
_IDS = itertools.count(os.getpid() << 8)
"""Two ids per view, so that a closed view does not delete the picture of the next one."""


def put(picture: Bytes, image_id: int, rows: int, cols: int) -> str:
    """Return the sequences that show a picture (rows, cols, 3) on ``rows`` x ``cols`` cells, from the cursor on.

    The cursor does not move, and the terminal does not answer. ``image_id``: 1 to 2**32 - 1; an existing image with
    this id is replaced.
    """
    data = base64.standard_b64encode(zlib.compress(picture.tobytes(), _FAST)).decode("ascii")
    height, width = picture.shape[:2]
    keys = f"a=T,q=2,C=1,f=24,o=z,s={width},v={height},i={image_id},p=1,c={cols},r={rows},"
    chunks = [data[at : at + _CHUNK] for at in range(0, len(data), _CHUNK)]
    last = len(chunks) - 1
    return "".join(
        f"\x1b_G{keys if place == 0 else ''}m={int(place < last)};{chunk}\x1b\\" for place, chunk in enumerate(chunks)
    )


def delete(image_id: int) -> str:
    """Return the sequence that deletes an image from the screen and from the terminal's memory."""
    return f"\x1b_Ga=d,d=I,q=2,i={image_id}\x1b\\"


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
