"""How late the messages of a sender are, whose clock may be another one than ours."""

from __future__ import annotations

_DRIFT_RATIO = 200e-6
"""Clocks drift against each other by less than this."""


class Delay:
    """The smallest delay between stamp and arrival, which holds the offset of the two clocks.

    It leaks upwards by 200 ppm, so that a sender's clock that runs slow is followed. The price: an edge that stays
    delayed by 1 s looks fresh again after more than an hour.
    """

    def __init__(self, delay_s: float, arrival_s: float) -> None:
        self.base_s = delay_s
        """The smallest delay, seconds; negative where the sender's clock is ahead of ours."""
        self._arrival_s = arrival_s

    def is_ahead(self, delay_s: float, arrival_s: float, max_age_s: float) -> bool:
        """Return whether a delay is too small to be one: by more than ``max_age_s`` and what clocks drift."""
        return delay_s < self.base_s - max_age_s - self._drift_s(arrival_s)

    def add(self, delay_s: float, arrival_s: float) -> None:
        """Take the delay of an accepted message."""
        self.base_s = min(delay_s, self.base_s + self._drift_s(arrival_s))
        self._arrival_s = arrival_s

    def lateness_s(self, delay_s: float, max_age_s: float) -> float:
        """Return how late a message with this delay is, at least 0.

        Clocks that differ by less than ``max_age_s`` are taken to agree: a constant transport delay then counts.
        Otherwise only what exceeds the smallest delay counts.
        """
        return max(0.0, delay_s if abs(self.base_s) < max_age_s else delay_s - self.base_s)

    def _drift_s(self, arrival_s: float) -> float:
        return _DRIFT_RATIO * max(0.0, arrival_s - self._arrival_s)
