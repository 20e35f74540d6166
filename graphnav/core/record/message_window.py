"""Rates, periods and sizes over a channel's newest messages, and when a channel counts as silent."""

from __future__ import annotations

import itertools
import math
import statistics
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

RECENT_S = 10.0
"""The time window of live rates; at least two messages."""
_MAX_MESSAGES = 10_000
_RECENT_MESSAGES = 100
_SILENT_PERIODS = 3
_SILENT_S = 1.0


def silent_after_s(period_s: float | None, min_s: float = _SILENT_S) -> float:
    """Return the time without a message after which a sender with this period is silent.

    It is 3 periods, at least ``min_s``; ``period_s``: None if it is not known.
    """
    return max(min_s, _SILENT_PERIODS * (period_s or 0.0))


@dataclass(frozen=True)
class Periods:
    """Rate and periods of the messages in a window.

    ``min_s``, ``mean_s``, ``max_s``, ``std_s``: of the periods between consecutive messages, without those that span
    lost messages; None without any. ``rate_hz`` includes lost messages. ``n``: messages in the window.
    """

    rate_hz: float
    min_s: float | None
    max_s: float | None
    std_s: float | None
    n: int
    mean_s: float | None = None


class Sizes(NamedTuple):
    """The messages in a window: their number and sizes in bytes."""

    n: int
    min_bytes: int
    mean_bytes: float
    max_bytes: int


class Window:
    """The newest messages on one clock: up to 10,000, and optionally of the last ``recent_s`` seconds."""

    def __init__(self, recent_s: float | None, max_messages: int = _MAX_MESSAGES) -> None:
        self._recent_s = math.inf if recent_s is None else recent_s
        self._newest: deque[tuple[float, float, int, int]] = deque(maxlen=max_messages)

    def add(self, at_s: float, time_s: float, number: int, n_bytes: int = 0) -> None:
        """Add a message that arrived at ``at_s``; ``time_s`` is its time on the window's clock.

        ``n_bytes`` is for `sizes` and `bytes_per_s`.
        """
        self._newest.append((at_s, time_s, number, n_bytes))
        while len(self._newest) > 2 and at_s - self._newest[0][0] > self._recent_s:
            self._newest.popleft()

    @property
    def is_empty(self) -> bool:
        """Whether the window has no messages."""
        return not self._newest

    @property
    def newest_s(self) -> float:
        """The arrival of the newest message; raises IndexError without messages."""
        return self._newest[-1][0]

    def behind_s(self) -> float | None:
        """Return the median delay from the messages' times to their arrivals, over the newest 100."""
        if not self._newest:
            return None
        newest = itertools.islice(reversed(self._newest), _RECENT_MESSAGES)
        return statistics.median(at_s - time_s for at_s, time_s, *_ in newest)

    def sizes(self) -> Sizes:
        """Return the sizes; raises ValueError without messages."""
        sizes = [n_bytes for *_, n_bytes in self._newest]
        return Sizes(len(sizes), min(sizes), sum(sizes) / len(sizes), max(sizes))

    def bytes_per_s(self) -> float | None:
        """Return the bytes of all messages except the first per second; None for a zero duration."""
        length_s = self._length_s()
        return (sum(n_bytes for *_, n_bytes in self._newest) - self._newest[0][-1]) / length_s if length_s > 0 else None

    @property
    def period_s(self) -> float | None:
        """The mean time between two messages, including lost ones; None for a zero duration."""
        rate_hz = self.rate_hz()
        return 1 / rate_hz if rate_hz else None

    def rate_hz(self) -> float | None:
        """Return messages per second, including lost ones; None for a zero duration."""
        length_s = self._length_s()
        return (self._newest[-1][2] - self._newest[0][2]) / length_s if length_s > 0 else None

    def _length_s(self) -> float:
        """Return the time from the first to the last message, 0 without messages."""
        return self._newest[-1][1] - self._newest[0][1] if self._newest else 0.0

    def periods(self) -> Periods | None:
        """Return the periods, None for fewer than two messages or a zero duration."""
        rate_hz = self.rate_hz()
        if rate_hz is None:
            return None
        _, times, numbers, _ = np.array(self._newest, np.float64).T
        steps = np.diff(times)[np.diff(numbers) == 1]
        if not steps.size:
            return Periods(rate_hz, None, None, None, len(times))
        min_s, max_s = float(steps.min()), float(steps.max())
        return Periods(rate_hz, min_s, max_s, float(steps.std()), len(times), float(steps.mean()))
