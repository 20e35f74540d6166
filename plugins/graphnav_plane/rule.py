"""Thresholds of an obstacle score."""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

Rule = Literal["mad", "otsu", "fixed"]

_BINS = 128


def threshold(rule: Rule, scores: npt.NDArray[np.floating], mad_ratio: float, min_px: float) -> float:
    """Return the score above which a cell is obstacle, at least ``min_px``.

    ``scores``: (n,), deviations from the ground in px, none negative, so that their median is the median absolute
    deviation (MAD). "mad": ``mad_ratio`` times it. "otsu": the split that maximizes the variance between both sides
    [Otsu: A threshold selection method from gray-level histograms, 1979]. "fixed": ``min_px``.
    """
    if rule == "fixed" or not scores.size:
        return min_px
    return max(min_px, mad_ratio * _median(scores) if rule == "mad" else _otsu(scores))


def _median(scores: npt.NDArray[np.floating]) -> float:
    """Return numpy's median of scores without NaN, several times as fast."""
    half = scores.size // 2
    if scores.size % 2:
        return float(np.partition(scores, half)[half])
    low, high = np.partition(scores, (half - 1, half))[half - 1 : half + 1]
    return float((low + high) / 2)


def _otsu(scores: npt.NDArray[np.floating]) -> float:
    count, edges = np.histogram(scores, _BINS)
    middle = (edges[:-1] + edges[1:]) / 2
    below = np.cumsum(count)[:-1]
    total = np.cumsum(count * middle)
    above = scores.size - below
    mean_gap = total[:-1] / np.maximum(below, 1) - (total[-1] - total[:-1]) / np.maximum(above, 1)
    return float(edges[1 + np.argmax(below * above * mean_gap**2)])
