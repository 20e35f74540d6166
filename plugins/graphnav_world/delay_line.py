"""A delay of constant length."""

from __future__ import annotations

import math
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class DelayLine(Generic[T]):
    """Gives values back a constant time after they were put in, in their order. Times are microseconds."""

    def __init__(self, delay_us: int) -> None:
        self._delay_us = delay_us
        self._waiting: deque[tuple[int, T]] = deque()

    @property
    def next_us(self) -> float:
        """When the next value is due; infinite if there is none."""
        return self._waiting[0][0] if self._waiting else math.inf

    def put(self, value: T, now_us: int) -> None:
        """Add a value; times must not decrease."""
        self._waiting.append((now_us + self._delay_us, value))

    def due(self, now_us: int) -> list[tuple[int, T]]:
        """Return the values that have become due since the last call, each once, with the times at which they did."""
        values = []
        while self.next_us <= now_us:
            values.append(self._waiting.popleft())
        return values
