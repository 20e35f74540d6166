"""The periods of a channel over its newest messages."""

from __future__ import annotations

import itertools
import math
import statistics
from collections import deque
from dataclasses import dataclass

import numpy as np

RECENT_S = 10.0
"""How far back a live rate looks; two messages at least."""
MAX_MESSAGES = 10_000
_RECENT_MESSAGES = 100


@dataclass(frozen=True)
class Periods:
    """Rate and periods of the messages in a window.

    ``min_s``, ``mean_s``, ``max_s``, ``std_s``: of the periods between neighbours, without those that span lost
    messages; None where there are none. ``rate_hz`` counts the lost ones. ``n``: messages in the window.
    """

    rate_hz: float
    min_s: float | None
    max_s: float | None
    std_s: float | None
    n: int
    mean_s: float | None = None


class Window:
    """The newest messages on one clock: up to 10,000, and of the last ``recent_s`` seconds if that is given."""

    def __init__(self, recent_s: float | None) -> None:
        self._recent_s = math.inf if recent_s is None else recent_s
        self._newest: deque[tuple[float, float, int]] = deque(maxlen=MAX_MESSAGES)

    def add(self, at_s: float, time_s: float, number: int) -> None:
        """Take a message that arrived at ``at_s``; ``time_s`` is its time on the window's clock."""
        self._newest.append((at_s, time_s, number))
        while len(self._newest) > 2 and at_s - self._newest[0][0] > self._recent_s:
            self._newest.popleft()

    @property
    def is_empty(self) -> bool:
        """Whether no message was taken."""
        return not self._newest

    def behind_s(self) -> float | None:
        """Return the median time from the messages' own times to their arrivals, over the newest 100."""
        if not self._newest:
            return None
        newest = itertools.islice(reversed(self._newest), _RECENT_MESSAGES)
        return statistics.median(at_s - time_s for at_s, time_s, _ in newest)

    def periods(self) -> Periods | None:
        """Return the periods, None below two messages or where no time passed between the first and the last."""
        if len(self._newest) < 2:
            return None
        _, times, numbers = np.array(self._newest, np.float64).T
        length_s = float(times[-1] - times[0])
        if length_s <= 0:
            return None
        rate_hz = float(numbers[-1] - numbers[0]) / length_s
        steps = np.diff(times)[np.diff(numbers) == 1]
        if not steps.size:
            return Periods(rate_hz, None, None, None, len(times))
        least_s, most_s = float(steps.min()), float(steps.max())
        return Periods(rate_hz, least_s, most_s, float(steps.std()), len(times), float(steps.mean()))
