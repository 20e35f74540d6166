"""How many messages came in each of the last seconds."""

from __future__ import annotations

import math
from collections import deque

SECONDS = 60


class RateHistory:
    """Counts of the last 60 whole seconds and of the one that runs."""

    def __init__(self) -> None:
        self._seconds: deque[int] = deque(maxlen=SECONDS)
        self._second = 0
        self._count = 0
        self._is_empty = True

    def add(self, at_s: float) -> None:
        """Count a message; one that is older than the newest counts with it."""
        if self._is_empty and math.isfinite(at_s):
            self._second, self._is_empty = math.floor(at_s), False
        self._advance(at_s)
        self._count += 1

    def counts(self, now_s: float) -> list[int]:
        """Return the messages of each whole second up to now, oldest first: at most 60, none before the first."""
        self._advance(now_s)
        return list(self._seconds)

    def _advance(self, to_s: float) -> None:
        """Close the seconds that have passed; a jump of a clock costs no more than 60 of them."""
        if self._is_empty or not math.isfinite(to_s) or to_s < self._second + 1:
            return
        self._seconds.append(self._count)
        self._count = 0
        missed = math.floor(to_s) - self._second - 1
        self._seconds.extend([0] * min(missed, SECONDS))
        self._second = math.floor(to_s)
