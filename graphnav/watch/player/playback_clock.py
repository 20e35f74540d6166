"""A clock for log time."""

from __future__ import annotations

import math
import time
from collections.abc import Callable


class PlaybackClock:
    """Log time derived from a monotonic clock relative to one anchor, so that delays do not accumulate.

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
        """The current log time."""
        if self.is_paused:
            return self._anchor_us
        return self._anchor_us + (self._now_s() - self._anchor_s) * 1e6 * self._speed_ratio

    def wait_s(self, at_us: float) -> float:
        """Return the seconds until a log time, negative if it has passed, infinite while paused."""
        if self.is_paused:
            return math.inf
        return self._anchor_s + (at_us - self._anchor_us) / 1e6 / self._speed_ratio - self._now_s()

    def seek(self, at_us: float) -> None:
        """Continue from a log time."""
        self._anchor_us, self._anchor_s = at_us, self._now_s()

    def pause(self) -> None:
        """Stop the clock."""
        self.seek(self.at_us)
        self.is_paused = True

    def resume(self) -> None:
        """Restart the clock."""
        self.seek(self.at_us)
        self.is_paused = False

    def set_speed(self, speed_ratio: float) -> None:
        """Continue at another speed."""
        self.seek(self.at_us)
        self._speed_ratio = speed_ratio
