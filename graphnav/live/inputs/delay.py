"""Estimate the lateness of messages whose sender has a different clock."""

from __future__ import annotations

_DRIFT_RATIO = 200e-6
"""Upper bound of the relative drift of two clocks."""


class Delay:
    """The smallest delay between stamp and arrival, which includes the offset of the two clocks.

    It rises by 200 ppm, to follow a sender's clock that runs slow. The cost: an edge that stays delayed by 1 s looks
    fresh again after more than an hour.
    """

    def __init__(self, delay_s: float, arrival_s: float) -> None:
        self.base_s = delay_s
        """The smallest delay in seconds; negative if the sender's clock is ahead of ours."""
        self._arrival_s = arrival_s

    def is_ahead(self, delay_s: float, arrival_s: float, max_age_s: float) -> bool:
        """Return whether a delay is implausibly small: by more than ``max_age_s`` and the drift of clocks."""
        return delay_s < self.base_s - max_age_s - self._drift_s(arrival_s)

    def add(self, delay_s: float, arrival_s: float) -> None:
        """Add the delay of an accepted message."""
        self.base_s = min(delay_s, self.base_s + self._drift_s(arrival_s))
        self._arrival_s = arrival_s

    def lateness_s(self, delay_s: float, max_age_s: float) -> float:
        """Return how late a message with this delay is, at least 0.

        Clocks that differ by less than ``max_age_s`` are assumed to agree: a constant transport delay then counts as
        lateness. Otherwise only the excess over the smallest delay counts.
        """
        return max(0.0, delay_s if abs(self.base_s) < max_age_s else delay_s - self.base_s)

    def _drift_s(self, arrival_s: float) -> float:
        return _DRIFT_RATIO * max(0.0, arrival_s - self._arrival_s)
