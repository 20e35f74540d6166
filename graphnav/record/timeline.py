"""When the events of a log happened, however its stamps jump."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

_MAX_GAP_US = 86_400_000_000
"""Between two events; what is longer is a clock that was set, or a damaged stamp."""


class Timeline:
    """The times of events in microseconds since the first one, which never decrease.

    ``utimes``: the stamps of the events, in the order of the file. A stamp that fits neither the one before nor the one
    behind it counts as that of the event before; where a clock was set, time goes on without a step. ``n_jumps`` counts
    both.
    """

    def __init__(self, utimes: Sequence[int]) -> None:
        self.at_us = array("q")
        self.n_jumps = 0
        now, clock = 0, utimes[0] if utimes else 0
        for number, utime in enumerate(utimes):
            following = utimes[number + 1] if number + 1 < len(utimes) else None
            step = utime - clock
            is_step = 0 <= step <= _MAX_GAP_US
            if is_step and (following is None or not clock <= following < utime):
                now, clock = now + step, utime
            else:
                self.n_jumps += 1
                if not is_step and (following is None or not 0 <= following - clock <= _MAX_GAP_US):
                    clock = utime
            self.at_us.append(now)

    def __len__(self) -> int:
        return len(self.at_us)

    @property
    def duration_us(self) -> int:
        """The time of the last event."""
        return self.at_us[-1] if self.at_us else 0
