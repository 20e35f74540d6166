"""Whether a process that ended before its run did is started again."""

from __future__ import annotations

import signal
from collections import deque

from graphnav.core.graph import Part


class Restarts:
    """Counts the restarts of a process by the policy of its part; times are monotonic seconds."""

    def __init__(self, part: Part) -> None:
        self._part = part
        self._at_s: deque[float] = deque()

    @property
    def count(self) -> int:
        """Restarts in the window, with the one that `delay_s` granted last."""
        return len(self._at_s)

    def may_follow(self, status: int) -> bool:
        """Whether the policy starts a process again that ended with this exit status, negative for a signal."""
        return self._part.restart == "always" or (self._part.restart == "on_failure" and status != 0)

    def delay_s(self, now_s: float) -> float | None:
        """Return how long to wait before the next restart, None if there were too many in the window."""
        while self._at_s and now_s - self._at_s[0] > self._part.restart_window_s:
            self._at_s.popleft()
        if len(self._at_s) >= self._part.max_restarts:
            return None
        self._at_s.append(now_s)
        return self._part.restart_delay_s * 2.0 ** (len(self._at_s) - 1)


def ending(status: int) -> str:
    """Return how a process ended, for a sentence: ``was killed by SIGKILL``."""
    if status >= 0:
        return f"ended with exit status {status}"
    try:
        return f"was killed by {signal.Signals(-status).name}"
    except ValueError:
        return f"was killed by signal {-status}"
