"""Obstacles that move: found by comparing what is seen of the floor now with what was seen a moment ago."""

from __future__ import annotations

import math
from collections import deque
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Bools, Bytes, Doubles, Indices
from graphnav_mapping.rolling_grid import GROUND, OBSTACLE, Box

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
    """Labels (rows, cols) of the cells in a box of the grid at a time; all else was not seen.

    Boxes and cells of looks and movers count from the first corner that the grid had. ``grid``: all of its cells.
    """

    utime: int
    labels: Bytes
    box: Box
    grid: Box

    def cut(self, box: Box) -> Bytes:
        """Return the labels in another box, 0 where nothing was seen."""
        found = np.zeros(box.shape, np.uint8)
        both = self.box.within(box)
        found[both.moved(-box.top, -box.left).cells] = self.labels[both.moved(-self.box.top, -self.box.left).cells]
        return found

    def shows(self, rows: Indices, cols: Indices) -> bool:
        """Whether any of these cells was judged."""
        inside = _inside(rows, cols, self.box)
        return bool(self.labels[rows[inside] - self.box.top, cols[inside] - self.box.left].any())


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
    """A mover as it was at a time; ``since``: when it was seen first."""

    utime: int
    mover: Mover
    since: int

    def now(self, look: Look) -> Mover:
        """Return the mover where it is expected at a look."""
        elapsed_s = (look.utime - self.utime) * 1e-6
        rows = self.mover.rows + round(elapsed_s * self.mover.rows_per_s)
        cols = self.mover.cols + round(elapsed_s * self.mover.cols_per_s)
        inside = _inside(rows, cols, look.grid)
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
            self._found.append(Track(look.utime, mover, min(begun, default=look.utime)))
        tracks = [track for track in self._found if look.utime - track.since >= _SURE_US]
        seen = [track.mover for track in tracks]
        for track in self._tracks:
            mover = track.now(look)
            is_recent = look.utime - track.utime <= _KEPT_US
            if is_recent and len(mover.rows) and not look.shows(mover.rows, mover.cols):
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
        is_obstacle, was = look.labels == OBSTACLE, before.cut(look.box)
        is_new = is_obstacle & (was == GROUND)
        if not is_new.any():
            return []
        reach = round(self._reach_m * elapsed_s / self._cell_m)
        around = look.box.grown(reach + 1)
        there = cv2.dilate((before.cut(around) == OBSTACLE).view(np.uint8), _NEAR)
        inner = look.box.moved(-around.top, -around.left)
        is_new &= there[inner.cells] == 0
        _, regions, stats, _ = cv2.connectedComponentsWithStats(is_obstacle.view(np.uint8), connectivity=8)
        movers = []
        for region in np.unique(regions[is_new]).tolist():
            left, top, width, height, count = stats[region].tolist()
            box = Box(top, left, top + height, left + width)
            cells = regions[box.cells] == region
            if count < _MIN_CELLS or np.count_nonzero(is_new[box.cells] & cells) < _MIN_NEW_RATIO * count:
                continue
            down, right = self._shift(cells, there[box.moved(inner.top, inner.left).grown(reach).cells], reach)
            if math.hypot(down, right) * self._cell_m >= min_speed_mps * elapsed_s:
                rows, cols = np.nonzero(cells)
                rows, cols = rows + (look.box.top + top), cols + (look.box.left + left)
                movers.append(Mover(rows, cols, down / elapsed_s, right / elapsed_s))
        return movers

    def _shift(self, cells: Bools, there: Bytes, reach: int) -> tuple[int, int]:
        """Return by how many rows and columns the cells have moved from where an obstacle was, 0 if unknown.

        ``there``: uint8, 1 where an obstacle was, up to ``reach`` cells around the box of the ``cells``.
        """
        # By rows and columns, from a shift back by ``reach`` on.
        overlap = np.rint(cv2.matchTemplate(there, cells.view(np.uint8), cv2.TM_CCORR))[::-1, ::-1].astype(np.float64)
        overlap /= np.count_nonzero(cells)
        still = overlap[reach, reach]
        overlap -= _shift_costs(reach)
        down, right = divmod(int(overlap.argmax()), len(overlap))
        if overlap[down, right] <= still + _MIN_GAIN_RATIO:
            return 0, 0
        return down - reach, right - reach


@lru_cache(maxsize=16)
def _shift_costs(reach: int) -> Doubles:
    shifts = np.arange(-reach, reach + 1)
    costs: Doubles = 0.02 * np.hypot(shifts[:, None], shifts)
    return costs


def _inside(rows: Indices, cols: Indices, box: Box) -> Bools:
    """Return which of the cells are in a box."""
    return np.asarray((rows >= box.top) & (rows < box.bottom) & (cols >= box.left) & (cols < box.right))


def swept(grid: Box, movers: list[Mover], ahead_s: float) -> Bytes:
    """Return the cells (rows, cols) of a box that the movers reach within a time, uint8 0 or 1."""
    found = np.zeros(grid.shape, np.uint8)
    for mover in movers:
        steps = max(1, round(ahead_s * max(abs(mover.rows_per_s), abs(mover.cols_per_s))))
        shares = np.linspace(0.0, 1.0, steps + 1) * ahead_s
        row = np.rint(np.add.outer(mover.rows - grid.top, shares * mover.rows_per_s)).astype(np.intp)
        col = np.rint(np.add.outer(mover.cols - grid.left, shares * mover.cols_per_s)).astype(np.intp)
        inside = _inside(row, col, Box(0, 0, *grid.shape))
        found[row[inside], col[inside]] = 1
    return found
