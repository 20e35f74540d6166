"""Frames of a detector beside the truth, kept until there are many to count in one pass."""

from __future__ import annotations

import numpy as np

from graphnav import Plane
from graphnav.arrays import Doubles, Floats, Longs

_MAX_CELLS = 1 << 15
"""Enough that the calls cost nothing beside the cells, few enough for the processor's caches."""


class Frames:
    """Room for frames of a grid of this shape, (rows, cols): 0.5 MB, or what one frame takes if that is more.

    ``n``: how many are kept.
    """

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.shape = shape
        rows, cols = shape
        size = 1 + _MAX_CELLS // (1 + rows * cols)
        self._pixels = np.empty((size, 2, rows, cols), np.float32)
        self._score = np.empty((size, rows, cols), np.float32)
        # Row 0 is the frame before the first; where nothing was judged, nothing changed.
        self._judged, self._called, self._true = np.zeros((3, 1 + size, rows, cols), np.bool_)
        self._counts, self._is_empty, self._moves = np.zeros((3, size), np.bool_)
        self.n = 0

    def add(self, plane: Plane, pixels: Floats, *, counts: bool, is_empty: bool, moves: bool) -> None:
        """Keep a frame with its true pixels, (2, rows, cols), ground and obstacle; for flicker every frame counts."""
        n = self.n
        self._pixels[n], self._score[n] = pixels, plane.score
        self._counts[n], self._is_empty[n], self._moves[n] = counts, is_empty, moves
        n += 1
        np.not_equal(plane.valid, 0, out=self._judged[n])
        np.not_equal(plane.obstacle, 0, out=self._called[n])
        np.greater(pixels[1], pixels[0], out=self._true[n])
        self.n = n

    @property
    def is_full(self) -> bool:
        """Whether there is no room for another frame."""
        return self.n == len(self._score)

    def confusions(self) -> tuple[Longs, Longs, Longs]:
        """Return how many pixels, ground and obstacle, are called ground and obstacle, and not judged, (2, 3) each.

        First of the frames that count, then of those without any obstacle, then of all that move.
        """
        n = self.n
        judged, called = self._judged[1 : 1 + n], self._called[1 : 1 + n]
        calls = np.stack([judged & ~called, judged & called, ~judged], axis=1).reshape(n, 3, -1)
        # In float64 the sums are exact; a product of stacked matrices of it takes five times as long.
        by_frame = np.einsum("nkc,nlc->nkl", self._pixels[:n].reshape(n, 2, -1), calls, dtype=np.float64)
        pixels = by_frame.astype(np.int64)
        counted, empty, moving = (
            pixels[chosen[:n]].sum(axis=0) for chosen in (self._counts, self._is_empty, self._moves)
        )
        return counted, empty, moving

    def flicker(self) -> tuple[int, int]:
        """Return how many cells changed their map although the truth did not, and how many kept it."""
        judged, called, true = (cells[: 1 + self.n] for cells in (self._judged, self._called, self._true))
        steady = judged[1:] & judged[:-1] & (true[1:] == true[:-1])
        changed = int(np.count_nonzero(steady & (called[1:] != called[:-1])))
        return changed, int(np.count_nonzero(steady)) - changed

    def scores(self, *, counted: bool) -> tuple[Floats, Doubles, Doubles]:
        """Return the scores of the judged cells of some frames, and their pixels: obstacle, and ground; (n,).

        Of the frames that count, or of the others that move.
        """
        n = self.n
        chosen = self._counts[:n] if counted else self._moves[:n] & ~self._counts[:n]
        cells = np.flatnonzero(self._judged[1 : 1 + n] & chosen[:, None, None])
        ground, obstacle = (self._pixels[:n, kind].reshape(-1).take(cells).astype(np.float64) for kind in range(2))
        return self._score[:n].reshape(-1).take(cells), obstacle, ground

    def clear(self) -> None:
        """Make room, but keep the last frame, with which the next is compared."""
        for cells in (self._judged, self._called, self._true):
            cells[0] = cells[self.n]
        self.n = 0
