"""Schedule the stops of a motor channel."""

from __future__ import annotations

import math

STOP_PERIOD_S = 0.02
STOP_FOR_S = 1.0
"""How long a stop is repeated at 50 Hz: single messages get lost, and an actuator may just be starting."""


class StopSchedule:
    """The due times of one channel's stops; all times are monotonic seconds.

    Stops are due at once, and repeated, when they are ordered and when a channel that had a command gets none for
    ``max_age_s``; while it stays silent one more is due every ``max_age_s``. A command ends them.
    """

    def __init__(self, max_age_s: float) -> None:
        self._max_age_s = max_age_s
        self._command_s = -math.inf
        self._repeat_until_s = -math.inf
        self._due_s = math.inf

    @property
    def due_s(self) -> float:
        """Time at which the next stop is due, infinite if none is scheduled."""
        return min(self._due_s, self._silent_s)

    def command(self, sent_s: float) -> None:
        """Note a command that is forwarded."""
        self._command_s = sent_s
        self._due_s = math.inf

    def order(self, now_s: float) -> None:
        """Make stops due from now on."""
        self._due_s = now_s
        self._repeat_until_s = now_s + STOP_FOR_S

    def take(self, now_s: float) -> bool:
        """Return whether a stop is due, and schedule the next one."""
        if now_s < self.due_s:
            return False
        if self._due_s == math.inf:
            self._repeat_until_s = now_s + STOP_FOR_S
        if now_s < self._repeat_until_s:
            self._due_s = now_s + STOP_PERIOD_S
        elif self._command_s == -math.inf:
            self._due_s = math.inf
        else:
            self._due_s = now_s + max(self._max_age_s, STOP_PERIOD_S)
        return True

    @property
    def _silent_s(self) -> float:
        """Time at which the silence becomes too long, infinite while stopped or before the first command."""
        is_waiting = self._due_s == math.inf and self._command_s > -math.inf
        return self._command_s + self._max_age_s if is_waiting else math.inf
