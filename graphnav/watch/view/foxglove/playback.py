"""The playback state of a log, and requests of Foxglove's playback controls."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

_MIN_SPEED_RATIO, _MAX_SPEED_RATIO = 0.01, 100.0


class Status(Enum):
    """Whether the log is playing."""

    PLAYING = "playing"
    PAUSED = "paused"
    ENDED = "ended"


@dataclass(frozen=True)
class Playback:
    """The playback state: microseconds from the beginning of the log, seconds of the log per second.

    ``jump``: the number of jumps.
    """

    status: Status
    at_us: int
    speed_ratio: float
    jump: int


@dataclass(frozen=True)
class Request:
    """A request of a client; ``seek_us``: None without a jump."""

    is_play: bool
    speed_ratio: float
    seek_us: int | None = None

    def speed_after(self, speed_ratio: float) -> float:
        """Return the requested speed, within limits; the previous speed if it is invalid."""
        if not math.isfinite(self.speed_ratio) or self.speed_ratio <= 0:
            return speed_ratio
        return min(max(self.speed_ratio, _MIN_SPEED_RATIO), _MAX_SPEED_RATIO)
