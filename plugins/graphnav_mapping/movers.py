"""Obstacles that move: found by comparing what is seen of the floor now with what was seen a moment ago."""

from __future__ import annotations

import math
from collections import deque
from typing import NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Bools, Bytes, Doubles, Indices
from graphnav_mapping.rolling_grid import GROUND, OBSTACLE, shifted

_MIN_CELLS = 6
_MIN_NEW_RATIO = 0.05
"""Share of an obstacle's cells that were free floor before: less is noise of its foot."""
_MIN_GAIN_RATIO = 0.1
"""By how much more of its cells a shift must explain than standing still does."""
_KEPT_US = 3_000_000
"""How long a mover that has left the view is expected to go on."""
_SURE_US = 90_000
"""How long an obstacle must be seen to move: a tenth of a second, less what stamps are off."""
_SAME_M = 0.08
_SAME_MPS = 0.3
"""How far a mover of the look before may be from where it was expected, and by how much its velocity may differ."""
_NEAR = np.ones((3, 3), np.uint8)


class Look(NamedTuple):
    """Labels of the grid's cells at a time, and the grid's corner in cells, (columns, rows) from its first corner."""

    utime: int
    labels: Bytes
    corner: tuple[int, int]


class Mover(NamedTuple):
    """The rows and columns of an obstacle's cells, (n,) each, and how many of them it moves in a second."""

    rows: Indices
    cols: Indices
    rows_per_s: float
    cols_per_s: float

    def continues(self, expected: Mover, cell_m: float) -> bool:
        """Whether this is likely to be a mover of the look before, where it is expected by now."""
        if not len(expected.rows):
            return False
        away = math.hypot(self.rows.mean() - expected.rows.mean(), self.cols.mean() - expected.cols.mean())
        slip = math.hypot(self.rows_per_s - expected.rows_per_s, self.cols_per_s - expected.cols_per_s)
        return cell_m * away <= _SAME_M and cell_m * slip <= _SAME_MPS


class Track(NamedTuple):
    """A mover as it was at a time, on the grid with this corner; ``since``: when it was seen first."""

    utime: int
    mover: Mover
    corner: tuple[int, int]
    since: int

    def now(self, look: Look) -> Mover:
        """Return the mover where it is expected at a look."""
        elapsed_s = (look.utime - self.utime) * 1e-6
        down = elapsed_s * self.mover.rows_per_s + self.corner[1] - look.corner[1]
        right = elapsed_s * self.mover.cols_per_s + self.corner[0] - look.corner[0]
        rows, cols = self.mover.rows + round(down), self.mover.cols + round(right)
        inside = (rows >= 0) & (cols >= 0) & (rows < look.labels.shape[0]) & (cols < look.labels.shape[1])
        return self.mover._replace(rows=rows[inside], cols=cols[inside])


class Movers:
    """Finds the obstacles that have moved since a moment ago; those that leave the view are expected to go on.

    An obstacle moves if a part of its cells was free floor before, away from all obstacles, and a shift explains where
    it came from: the smallest one with which nearly most of its cells fall on obstacles of before. It counts once the
    looks of a tenth of a second, two at least, have found it with about the same velocity: most of what a single look
    finds does not move.

    Parameters
    ----------
    interval_s
        How long ago the moment is.
    max_speed_mps, cell_m
        Fastest obstacle, and the side of a cell.
    """

    def __init__(self, interval_s: float, max_speed_mps: float, cell_m: float) -> None:
        self._interval_us = round(1e6 * interval_s)
        self._reach_m, self._cell_m = max_speed_mps, cell_m
        self._looks: deque[Look] = deque()
        self._tracks: list[Track] = []
        self._found: list[Track] = []

    def find(self, look: Look, min_speed_mps: float) -> list[Mover]:
        """Return the obstacles that move at ``min_speed_mps`` at least, those out of view too; looks come in order."""
        expected = [(track.now(look), track.since) for track in self._found]
        self._found = []
        for mover in self._seen(look, min_speed_mps):
            begun = [since for before, since in expected if mover.continues(before, self._cell_m)]
            self._found.append(Track(look.utime, mover, look.corner, min(begun, default=look.utime)))
        tracks = [track for track in self._found if look.utime - track.since >= _SURE_US]
        seen = [track.mover for track in tracks]
        for track in self._tracks:
            mover = track.now(look)
            if (
                look.utime - track.utime <= _KEPT_US
                and len(mover.rows)
                and not look.labels[mover.rows, mover.cols].any()
            ):
                seen.append(mover)
                tracks.append(track)
        self._tracks = tracks
        return seen

    def _seen(self, look: Look, min_speed_mps: float) -> list[Mover]:
        self._looks.append(look)
        while len(self._looks) > 1 and self._looks[1].utime <= look.utime - self._interval_us:
            self._looks.popleft()
        before = self._looks[0]
        elapsed_s = (look.utime - before.utime) * 1e-6
        if look.utime - before.utime < self._interval_us / 2:
            return []
        was = shifted(before.labels, look.corner[0] - before.corner[0], look.corner[1] - before.corner[1])
        was_obstacle = (was == OBSTACLE).view(np.uint8)
        there = cv2.dilate(was_obstacle, _NEAR) != 0
        is_new = (was == GROUND) & ~there
        _, regions = cv2.connectedComponents((look.labels == OBSTACLE).view(np.uint8), connectivity=8)
        movers = []
        for region in np.unique(regions[is_new & (regions != 0)]):
            rows, cols = np.nonzero(regions == region)
            if len(rows) < _MIN_CELLS or is_new[rows, cols].mean() < _MIN_NEW_RATIO:
                continue
            shift = self._shift(rows, cols, there, elapsed_s)
            if np.hypot(*shift) * self._cell_m >= min_speed_mps * elapsed_s:
                movers.append(Mover(rows, cols, shift[0] / elapsed_s, shift[1] / elapsed_s))
        return movers

    def _shift(self, rows: Indices, cols: Indices, there: Bools, elapsed_s: float) -> tuple[int, int]:
        """Return by how many rows and columns the cells have moved from where an obstacle was, 0 if unknown."""
        reach = round(self._reach_m * elapsed_s / self._cell_m)
        shifts = np.arange(-reach, reach + 1)
        overlap = n_shared(rows, cols, there, reach) / len(rows) - 0.02 * np.hypot(shifts[:, None], shifts)
        down, right = divmod(int(overlap.argmax()), len(shifts))
        if overlap[down, right] <= there[rows, cols].mean() + _MIN_GAIN_RATIO:
            return 0, 0
        return down - reach, right - reach


def n_shared(rows: Indices, cols: Indices, there: Bools, reach: int) -> Doubles:
    """Return how many of the cells are ``there`` (rows, cols) if they are moved back by up to ``reach`` cells.

    (2 reach + 1, 2 reach + 1), by rows and columns: by -reach first.
    """
    top, left = rows.min(), cols.min()
    cells = np.zeros((rows.max() - top + 1, cols.max() - left + 1), np.uint8)
    cells[rows - top, cols - left] = 1
    around = np.pad(there.view(np.uint8), reach)[top:, left:][: len(cells) + 2 * reach, : cells.shape[1] + 2 * reach]
    counts = np.rint(cv2.matchTemplate(around, cells, cv2.TM_CCORR))
    return np.asarray(counts[::-1, ::-1], np.float64)


def swept(shape: tuple[int, int], movers: list[Mover], ahead_s: float) -> Bytes:
    """Return the cells (rows, cols) that the movers reach within a time, uint8 0 or 1."""
    found = np.zeros(shape, np.uint8)
    for mover in movers:
        steps = max(1, round(ahead_s * max(abs(mover.rows_per_s), abs(mover.cols_per_s))))
        for share in np.linspace(0.0, 1.0, steps + 1):
            row = np.rint(mover.rows + share * ahead_s * mover.rows_per_s).astype(np.intp)
            col = np.rint(mover.cols + share * ahead_s * mover.cols_per_s).astype(np.intp)
            inside = (row >= 0) & (col >= 0) & (row < shape[0]) & (col < shape[1])
            found[row[inside], col[inside]] = 1
    return found
