"""Where a log is being played, as Foxglove's playback controls ask for it and are told."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

_MIN_SPEED_RATIO, _MAX_SPEED_RATIO = 0.01, 100.0


class Status(Enum):
    """Whether the time of the log goes on."""

    PLAYING = "playing"
    PAUSED = "paused"
    ENDED = "ended"


@dataclass(frozen=True)
class Playback:
    """Where a log is being played: microseconds from its beginning, seconds of the log per second.

    ``jump`` grows with every jump.
    """

    status: Status
    at_us: int
    speed_ratio: float
    jump: int


@dataclass(frozen=True)
class Request:
    """What a client asks for; ``seek_us`` is None where it stays where it is."""

    is_play: bool
    speed_ratio: float
    seek_us: int | None = None

    def speed_after(self, speed_ratio: float) -> float:
        """Return the speed that is asked for, within limits; the one before where it is not a speed."""
        if not math.isfinite(self.speed_ratio) or self.speed_ratio <= 0:
            return speed_ratio
        return min(max(self.speed_ratio, _MIN_SPEED_RATIO), _MAX_SPEED_RATIO)
