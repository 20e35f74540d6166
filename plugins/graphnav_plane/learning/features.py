"""Inputs of the learned detector: each cell's flow, what the planar flow leaves of it, its neighbours, its place."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import Flow, Planar
from graphnav.arrays import Bools, Floats
from graphnav_plane.detector import compared
from graphnav_plane.memory import Memory
from graphnav_plane.one_gain import robust_gain

NAMES = (
    "flow_right_px",
    "flow_down_px",
    "planar_right_px",
    "planar_down_px",
    "left_right_px",
    "left_down_px",
    "left_px",
    "remembered_px",
    "remembered_3x3_px",
    "remembered_7x7_px",
    "contrast_px",
    "frame_left_px",
    "frame_planar_px",
    "gain",
    "row",
    "col",
    "abs_col",
)
"""Columns of the features: u; a û with a the robust gain of the frame; what is left, u - a û; its length; that of its
running mean, alone and averaged over 3x3 and 7x7 cells; the distance of u from the mean of its 5x5 cells; the frame's
medians of what is left and of the planar flow; a; the cell's place, -1 to 1."""

_NOISE_PX = 0.1
_REMEMBERED = 0.5


class Features:
    """The features of consecutive frames, with the running mean of what the planar flow leaves."""

    def __init__(self) -> None:
        self._memory = Memory(_REMEMBERED)

    def forget(self) -> None:
        """Start over: the next frame is used alone."""
        self._memory.forget()

    def of(self, flow: Flow, planar: Planar, min_vectors: int) -> tuple[Floats, Bools, int]:
        """Return the features of the judged cells (n, 17), which cells are judged (rows, cols), and their step, px.

        With fewer than ``min_vectors`` valid vectors no cell is judged.

        Raises
        ------
        ValueError
            Flow and planar flow are of different image sizes or cover different times.
        """
        cells, valid = compared(flow, planar)
        if np.count_nonzero(valid) < min_vectors:
            self.forget()
            return np.zeros((0, len(NAMES)), np.float32), np.zeros_like(valid), cells.step_px
        uv_px = np.where(valid[..., None], cells.uv_px, np.float32(0))
        planar_px = np.where(valid[..., None], planar.planar_uv_px, np.float32(0))
        gain = robust_gain(uv_px[valid].astype(float), planar_px[valid].astype(float), _NOISE_PX)
        planar_px = np.float32(gain) * planar_px
        left_px = uv_px - planar_px
        remembered_px = _length(self._memory.mean(left_px, valid, cells.uv_px / np.float32(cells.step_px)))
        length_px = _length(left_px)
        row, col = (
            np.broadcast_to(places, valid.shape)
            for places in (_places(valid.shape[0])[:, None], _places(valid.shape[1])[None])
        )
        fields = (
            *(uv_px[..., 0], uv_px[..., 1], planar_px[..., 0], planar_px[..., 1], left_px[..., 0], left_px[..., 1]),
            *(length_px, remembered_px, _around(remembered_px, valid, 3), _around(remembered_px, valid, 7)),
            _length(uv_px - np.dstack([_around(uv_px[..., axis], valid, 5) for axis in range(2)])),
            *(_everywhere(float(np.median(f[valid])), valid) for f in (length_px, _length(planar_px))),
            *(_everywhere(gain, valid), row, col, np.abs(col)),
        )
        return np.stack([field[valid] for field in fields], axis=-1), valid, cells.step_px


def _length(vectors: Floats) -> Floats:
    return np.asarray(np.hypot(vectors[..., 0], vectors[..., 1]))


def _around(field: Floats, valid: Bools, side: int) -> Floats:
    """Return the mean of the valid cells of ``field`` (rows, cols), 0 elsewhere, in a square around each cell."""
    size, border = (side, side), cv2.BORDER_CONSTANT
    sums = cv2.boxFilter(np.ascontiguousarray(field), -1, size, normalize=False, borderType=border)
    counts = cv2.boxFilter(valid.astype(np.float32), -1, size, normalize=False, borderType=border)
    return np.asarray(sums / np.maximum(counts, np.float32(1)))


def _everywhere(value: float, valid: Bools) -> Floats:
    return np.broadcast_to(np.float32(value), valid.shape)


def _places(size: int) -> Floats:
    return ((2 * np.arange(size) + 1 - size) / size).astype(np.float32)
