"""A receiver operating characteristic of any number of scores in constant memory."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Doubles, Floats, Ints

KEPT_BITS = 18
"""Of a float32's 32: sign, exponent and nine bits of the mantissa, so that a bin is at most 0.2 % wide."""


class Roc:
    """Counts of obstacle and of ground over a score, in bins that are dense wherever the scores are.

    A bin holds the scores whose float32 begins with the same bits, so that their scale does not matter (but scores
    that all lie within one percent of each other, far from zero, are not told apart). Ties inside a bin count half,
    as in the rank statistic. 5 MB.
    """

    def __init__(self) -> None:
        self._obstacle, self._ground = np.zeros((2, 1 << KEPT_BITS))
        self._lowest = np.zeros(2)

    def add(self, score: Floats, obstacle: Doubles, ground: Doubles) -> None:
        """Count ``obstacle`` and ``ground`` pixels at each ``score``; all (n,), scores finite.

        Of many frames at once it costs less: a call passes over all bins between the minimum and the maximum score.
        """
        if not len(score):
            return
        bins = _bins(score)
        low = int(bins.min())
        bins -= low
        for counts, pixels in ((self._obstacle, obstacle), (self._ground, ground)):
            added = np.bincount(bins, pixels)
            counts[low : low + len(added)] += added

    def add_lowest(self, obstacle: float, ground: float) -> None:
        """Count pixels that score less than everything else, and all alike."""
        self._lowest += (obstacle, ground)

    def merge(self, other: Roc) -> None:
        """Add what ``other`` counted."""
        self._obstacle += other._obstacle
        self._ground += other._ground
        self._lowest += other._lowest

    def area(self) -> float | None:
        """Return the area under the curve (AUROC), None unless there is obstacle and ground."""
        if not self._is_defined():
            return None
        lowest_obstacle, lowest_ground = self._lowest.tolist()
        below = np.cumsum(self._ground) - self._ground + lowest_ground
        pairs = (float(self._obstacle.sum()) + lowest_obstacle) * (float(self._ground.sum()) + lowest_ground)
        return (float(self._obstacle @ (below + self._ground / 2)) + lowest_obstacle * lowest_ground / 2) / pairs

    def recall(self, false_alarm_ratio: float) -> float | None:
        """Return the share of obstacle found where this share of the ground is called obstacle, interpolated."""
        if not self._is_defined():
            return None
        alarms, found = (
            np.concatenate([[0.0], np.cumsum(np.append(counts[::-1], lowest)) / (counts.sum() + lowest)])
            for counts, lowest in zip((self._ground, self._obstacle), self._lowest[::-1], strict=True)
        )
        after = int(np.searchsorted(alarms, false_alarm_ratio, side="right"))
        if after == len(alarms):
            return 1.0
        share = (false_alarm_ratio - alarms[after - 1]) / (alarms[after] - alarms[after - 1])
        return float(found[after - 1] + share * (found[after] - found[after - 1]))

    def _is_defined(self) -> bool:
        obstacle, ground = self._lowest.tolist()
        return bool((obstacle or self._obstacle.any()) and (ground or self._ground.any()))


def _bins(score: Floats) -> Ints:
    """Return the bin of every score; greater scores have no smaller bins (negative floats count backwards)."""
    bits = score.astype(np.float32, copy=False).view(np.int32)
    if bits.min(initial=0) < 0:
        bits = np.where(bits < 0, np.iinfo(np.int32).min - bits, bits)
    return np.asarray((bits >> (32 - KEPT_BITS)) + (1 << (KEPT_BITS - 1)))
