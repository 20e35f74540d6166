"""How many bytes go over a channel."""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from graphnav.spy.feed import Heard
from graphnav.spy.window import MAX_MESSAGES, RECENT_S


class Sizes(NamedTuple):
    """The newest messages of a channel: their number, sizes in bytes, and what arrives a second.

    ``bytes_per_s``: of all but the first, over the time between the first and the last; None below two arrivals.
    """

    n: int
    min_bytes: int
    mean_bytes: float
    max_bytes: int
    bytes_per_s: float | None


class Bandwidth:
    """The sizes of the newest messages: up to 10,000, and live of the last 10 s."""

    def __init__(self, *, is_live: bool) -> None:
        self._is_live = is_live
        self._newest: deque[tuple[float, int]] = deque(maxlen=MAX_MESSAGES)

    def hear(self, heard: Heard) -> None:
        """Count a message."""
        self._newest.append((heard.at_s, len(heard.data)))
        while self._is_live and len(self._newest) > 2 and heard.at_s - self._newest[0][0] > RECENT_S:
            self._newest.popleft()

    @property
    def sizes(self) -> Sizes:
        """What was heard; raises ValueError before the first message."""
        sizes = [size for _, size in self._newest]
        length_s = self._newest[-1][0] - self._newest[0][0]
        bytes_per_s = sum(sizes[1:]) / length_s if length_s > 0 else None
        return Sizes(len(sizes), min(sizes), sum(sizes) / len(sizes), max(sizes), bytes_per_s)
