"""Patterns that repeat: by how far a picture may be shifted and look the same."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np

from graphnav.arrays import Floats

LAYER = 1
"""The layer of the pyramid that is searched: periods of 6 px of the picture and more."""
_SIDE, _REACH = 24, 16
"""Side of the patches, and how far they are shifted, px of that layer."""
_COLS, _ROWS = 3, 2
_MIN_CORRELATION = np.float32(0.6)
"""From which on a shifted patch looks the same. On gravel and grass without a period it is below 0.4."""
_VALLEY_RATIO = 0.6
"""Between a patch and its repetition the correlation falls below this share: else both are parts of one stripe."""
_AMBIGUOUS_RATIO = 1 / 3
"""A displacement of more than this share of the period is ambiguous: a shift by one period more explains the pictures
as well, and is at most twice as long. A robot that speeds up gets there step by step."""
_BESIDE = np.ones((5, 5), np.uint8)


class Repetition:
    """Finds in each of six parts of a picture the shortest shift that leaves it the same.

    It looks at all parts of the first picture, and at a third of those of each later one: what it found in the others
    still holds, since a floor rarely changes its pattern.
    """

    def __init__(self) -> None:
        self._found_px = np.full((_ROWS, _COLS), math.inf, np.float32)
        self._next = range(_COLS)

    def ambiguous_px2(self, layers: Sequence[Floats], uv_px: Floats) -> Floats | None:
        """Return what ambiguity adds to the variance of ``uv_px`` (rows, cols, 2); None if nothing repeats.

        ``layers``: of the picture, the base first. Where a displacement is ambiguous, it may be off by a period.
        """
        if len(layers) <= LAYER:
            return None
        periods_px = 2**LAYER * self.periods_px(layers[LAYER])
        if not np.isfinite(periods_px).any():
            return None
        period_px = cv2.resize(periods_px, uv_px.shape[1::-1], interpolation=cv2.INTER_NEAREST)
        length_px = np.hypot(uv_px[..., 0], uv_px[..., 1])
        added: Floats = np.where(length_px > np.float32(_AMBIGUOUS_RATIO) * period_px, period_px**2, np.float32(0.0))
        return added

    def periods_px(self, layer: Floats) -> Floats:
        """Return the period in each part of the next picture, float32 (2, 3), px of the layer; inf without one."""
        rows, cols = layer.shape
        side = min(_SIDE, rows, cols)
        for j in self._next:
            left = j * (cols - side) // (_COLS - 1)
            for i in range(_ROWS):
                top = i * (rows - side) // (_ROWS - 1)
                up, before = min(top, _REACH), min(left, _REACH)
                around = layer[top - up : top + side + _REACH, left - before : left + side + _REACH]
                patch = layer[top : top + side, left : left + side]
                self._found_px[i, j] = _period_px(cv2.matchTemplate(around, patch, cv2.TM_CCOEFF_NORMED), (up, before))
        turn = (self._next[-1] + 1) % _COLS
        self._next = range(turn, turn + 1)
        return self._found_px


def _period_px(correlation: Floats, zero: tuple[int, int]) -> float:
    """Return the shortest shift to another peak of a correlation, inf without one; ``zero``: row and column of 0."""
    is_peak = correlation >= np.maximum(cv2.dilate(correlation, _BESIDE), _MIN_CORRELATION)
    down, right = np.nonzero(is_peak)
    if len(down) == 1:  # that of no shift
        return math.inf
    away = np.hypot(down - zero[0], right - zero[1])
    for k in np.argsort(away, kind="stable"):
        if away[k] < 2.0:
            continue
        share = np.linspace(0.0, 1.0, math.ceil(away[k]) + 1)
        along_rows = np.rint(zero[0] + share * (down[k] - zero[0])).astype(int)
        along_cols = np.rint(zero[1] + share * (right[k] - zero[1])).astype(int)
        if correlation[along_rows, along_cols].min() < _VALLEY_RATIO * correlation[down[k], right[k]]:
            return float(away[k])
    return math.inf
