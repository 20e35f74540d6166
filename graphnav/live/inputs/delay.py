"""Estimate the lateness of messages whose sender has a different clock."""

from __future__ import annotations

_DRIFT_RATIO = 200e-6
"""Upper bound of the relative drift of two clocks."""
_SETTLED = 10
"""Messages after which it is decided whether the clocks agree."""
_AGAIN_RATIO = 0.75
"""Clocks that do not agree agree again when they differ by less than this share of ``max_age_s``."""


class Delay:
    """The smallest delay between stamp and arrival, which includes the offset of the two clocks.

    It rises by 200 ppm, to follow a sender's clock that runs slow. The cost: an edge that stays delayed by 1 s looks
    fresh again after more than an hour.

    Clocks that differ by less than ``max_age_s`` are assumed to agree (``agrees``): a constant transport delay then
    counts as lateness. Otherwise only the excess over the smallest delay counts. After 10 messages, clocks that do not
    agree agree again only below 0.75 ``max_age_s``, so that the decision does not change from message to message.
    """

    def __init__(self, delay_s: float, arrival_s: float) -> None:
        self.base_s = delay_s
        """The smallest delay in seconds; negative if the sender's clock is ahead of ours."""
        self.agrees = True
        self._arrival_s = arrival_s
        self._n_decided = 0

    def is_ahead(self, delay_s: float, arrival_s: float, max_age_s: float) -> bool:
        """Return whether a delay is implausibly small: by more than ``max_age_s`` and the drift of clocks."""
        return delay_s < self.base_s - max_age_s - self._drift_s(arrival_s)

    def add(self, delay_s: float, arrival_s: float) -> None:
        """Add the delay of an accepted message."""
        self.base_s = min(delay_s, self.base_s + self._drift_s(arrival_s))
        self._arrival_s = arrival_s

    def lateness_s(self, delay_s: float, max_age_s: float) -> float:
        """Return how late an accepted message with this delay is, at least 0; called once for each."""
        is_settled = self._n_decided >= _SETTLED
        self._n_decided += 1
        self.agrees = abs(self.base_s) < (max_age_s if self.agrees or not is_settled else _AGAIN_RATIO * max_age_s)
        return max(0.0, delay_s if self.agrees else delay_s - self.base_s)

    def _drift_s(self, arrival_s: float) -> float:
        return _DRIFT_RATIO * max(0.0, arrival_s - self._arrival_s)
