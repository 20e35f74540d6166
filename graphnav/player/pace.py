"""Which time of a log it is."""

from __future__ import annotations

import math
import time
from collections.abc import Callable


class Pace:
    """Log time by a monotonic clock, from one anchor on, so that delays do not add up.

    ``speed_ratio``: seconds of the log per second. Times are microseconds since the log's first event.
    """

    def __init__(self, speed_ratio: float = 1.0, now_s: Callable[[], float] = time.monotonic) -> None:
        self.is_paused = False
        self._speed_ratio, self._now_s = speed_ratio, now_s
        self._anchor_us, self._anchor_s = 0.0, now_s()

    @property
    def speed_ratio(self) -> float:
        """Seconds of the log per second."""
        return self._speed_ratio

    @property
    def at_us(self) -> float:
        """The time in the log."""
        if self.is_paused:
            return self._anchor_us
        return self._anchor_us + (self._now_s() - self._anchor_s) * 1e6 * self._speed_ratio

    def wait_s(self, at_us: float) -> float:
        """Return the seconds until a time, negative if it has passed, infinite while paused."""
        if self.is_paused:
            return math.inf
        return self._anchor_s + (at_us - self._anchor_us) / 1e6 / self._speed_ratio - self._now_s()

    def seek(self, at_us: float) -> None:
        """Go on from a time."""
        self._anchor_us, self._anchor_s = at_us, self._now_s()

    def pause(self) -> None:
        """Stop the time."""
        self.seek(self.at_us)
        self.is_paused = True

    def resume(self) -> None:
        """Let the time go on."""
        self.seek(self.at_us)
        self.is_paused = False

    def set_speed(self, speed_ratio: float) -> None:
        """Go on at another speed."""
        self.seek(self.at_us)
        self._speed_ratio = speed_ratio
