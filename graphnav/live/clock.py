"""The clock of a live run: wall time at the start plus monotonic time."""

from __future__ import annotations

import time
from collections.abc import Callable


class LiveClock:
    """Reads monotonic seconds and converts them to stamps.

    Stamps never run backwards, even if the machine's time of day is set during the run.
    """

    def __init__(
        self, monotonic_s: Callable[[], float] = time.monotonic, wall_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self._monotonic_s = monotonic_s
        self.start_s = monotonic_s()
        self.start_utime = wall_ns() // 1000

    def now_s(self) -> float:
        """Return monotonic seconds."""
        return self._monotonic_s()

    def utime_at(self, time_s: float) -> int:
        """Return the stamp (microseconds) of a monotonic time."""
        return self.start_utime + round((time_s - self.start_s) * 1e6)

    def now(self) -> int:
        """Return the current stamp in microseconds."""
        return self.utime_at(self.now_s())

    def run_s(self) -> float:
        """Return the seconds since the start of the run."""
        return self.now_s() - self.start_s
