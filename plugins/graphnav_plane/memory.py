"""Running mean of the residuals of recent frames, moved along with the flow."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav.arrays import Bools, Floats


class Memory:
    """A running mean of vectors over the frames; each cell follows the flow.

    The contribution of an obstacle is similar from frame to frame; errors of the flow are not, and cancel as vectors.
    """

    def __init__(self, share: float) -> None:
        self._share = np.float32(share)
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
        now = np.where(valid[..., None], left_px, np.float32(0.0))
        if self._share and self._left_px.shape == now.shape:
            columns, rows = _came_from(moved_cells)
            was = cv2.remap(self._left_px, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            known = cv2.remap(self._valid, columns, rows, cv2.INTER_LINEAR, borderValue=0.0) > _WHOLLY
            both = (known & valid)[..., None]
            now = np.where(both, (1 - self._share) * now + self._share * was, now)
        self._left_px, self._valid = now, valid.astype(np.float32)
        return now


_WHOLLY = 0.99
"""The cells between which a cell came from must all have been valid; rounding leaves less than one."""


def _came_from(moved_cells: Floats) -> tuple[Floats, Floats]:
    """Return the columns and rows of the cells in the last frame, both float32 (rows, cols)."""
    rows, cols = moved_cells.shape[:2]
    columns = np.arange(cols, dtype=np.float32) - moved_cells[..., 0]
    return columns, np.arange(rows, dtype=np.float32)[:, None] - moved_cells[..., 1]
