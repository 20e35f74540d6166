"""The times of a log's events, corrected for jumps of their timestamps."""

from __future__ import annotations

from array import array
from collections.abc import Sequence

_MAX_GAP_US = 86_400_000_000
"""A longer gap between two events is a clock that was set, or a damaged timestamp."""


class Timeline:
    """The non-decreasing times of events, microseconds since the first one.

    ``utimes``: the timestamps of the events in file order. A timestamp that fits neither the previous nor the next one
    is replaced by the previous one; if a clock was set, time continues without a step. ``n_jumps`` counts both.
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
