"""Running mean of the residuals of recent frames, moved along with the flow."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np

from graphnav.arrays import Bools, Floats


class Memory:
    """A running mean of vectors over the frames; each cell follows the flow.

    The contribution of an obstacle is similar from frame to frame; errors of the flow are not, and cancel as vectors.
    """

    def __init__(self, share: float) -> None:
        self._share = share
        self.forget()

    def forget(self) -> None:
        """Start over: the next frame is used alone."""
        self._left_px: Floats = np.zeros((0, 0, 2), np.float32)
        self._valid: Floats = np.zeros((0, 0), np.float32)

    def mean(self, left_px: Floats, valid: Bools, moved_cells: Floats) -> Floats:
        """Return the running mean with this frame's ``left_px``, float32 (rows, cols, 2), zero where not ``valid``.

        ``moved_cells``: (rows, cols, 2), the flow in cells. Where the last frame has no value, or if the grid changed,
        this frame is used alone.
        """
        now = np.asarray(cv2.copyTo(left_px, valid.view(np.uint8)), np.float32)
        if self._share and self._left_px.shape == now.shape:
            before = _grid(*valid.shape) - moved_cells
            was = cv2.remap(self._left_px, before, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            known = cv2.remap(self._valid, before, None, cv2.INTER_LINEAR, borderValue=0.0) > _WHOLLY
            known &= valid
            cv2.copyTo(cv2.addWeighted(now, 1.0 - self._share, was, self._share, 0.0), known.view(np.uint8), now)
        self._left_px, self._valid = now, valid.astype(np.float32)
        return now


_WHOLLY = 0.99
"""The cells between which a cell came from must all have been valid; rounding leaves less than one."""


@lru_cache(maxsize=16)
def _grid(rows: int, cols: int) -> Floats:
    """Return the column and row of each cell, (rows, cols, 2)."""
    grid = np.dstack(np.meshgrid(np.arange(cols), np.arange(rows))).astype(np.float32)
    grid.setflags(write=False)
    return grid
