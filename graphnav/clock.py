"""How fast simulated time passes; what time it is, the stamps say."""

from __future__ import annotations

import time
from collections.abc import Callable

_MOST_LATE_S = 0.5
"""Behind by more than this, a paced clock gives the time up instead of making up for it."""


class SimulatedClock:
    """Jumps from stamp to stamp, as fast as the machine allows or at a pace that people can watch.

    ``pace_ratio``: simulated seconds per wall second; None does not wait at all.
    """

    def __init__(
        self,
        pace_ratio: float | None = None,
        wall_s: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._pace_ratio = pace_ratio
        self._wall_s, self._sleep = wall_s, sleep
        self._offset_s: float | None = None

    def advance(self, utime: int) -> None:
        """Let it be ``utime``, after the wait that the pace asks for; the first stamp comes at once."""
        if self._pace_ratio is None:
            return
        due_s = utime / 1e6 / self._pace_ratio
        wall_s = self._wall_s()
        if self._offset_s is None or wall_s - self._offset_s - due_s > _MOST_LATE_S:
            self._offset_s = wall_s - due_s
        elif (wait_s := due_s + self._offset_s - wall_s) > 0:
            self._sleep(wait_s)
