"""Count the messages in each of the last seconds."""

from __future__ import annotations

import math
from collections import deque

SECONDS = 60


class RateHistory:
    """Message counts of the last 60 complete seconds and of the current one."""

    def __init__(self) -> None:
        self._seconds: deque[int] = deque(maxlen=SECONDS)
        self._second = 0
        self._count = 0
        self._is_empty = True

    def add(self, at_s: float) -> None:
        """Count a message; a message older than the newest is counted with the newest."""
        if self._is_empty and math.isfinite(at_s):
            self._second, self._is_empty = math.floor(at_s), False
        self._advance(at_s)
        self._count += 1

    def counts(self, now_s: float) -> list[int]:
        """Return the counts of complete seconds up to now, oldest first: at most 60, none before the first message."""
        self._advance(now_s)
        return list(self._seconds)

    def _advance(self, to_s: float) -> None:
        """Close elapsed seconds; a clock jump closes at most 60."""
        if self._is_empty or not math.isfinite(to_s) or to_s < self._second + 1:
            return
        self._seconds.append(self._count)
        self._count = 0
        missed = math.floor(to_s) - self._second - 1
        self._seconds.extend([0] * min(missed, SECONDS))
        self._second = math.floor(to_s)
