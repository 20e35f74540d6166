"""Playing a log as Foxglove's playback controls request it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from graphnav.watch.export.entries.run_entries import MAX_UTIME
from graphnav.watch.feed import LogFeed

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


class Player:
    """Plays a log for clients, from its beginning once the first one has subscribed.

    ``begin_us`` is added to the times of the log for viewers: the timestamp of the first event, 0 if out of range for
    viewers. All methods are thread-safe.
    """

    def __init__(self, log: LogFeed) -> None:
        self.recording = log.recording
        self.duration_us = round(log.length_s * 1e6)
        first_us = self.recording.begin_us
        self.begin_us = first_us if 0 <= first_us < MAX_UTIME - self.duration_us else 0
        self._log = log
        self._is_begun = False

    @property
    def state(self) -> Playback:
        """The playback state."""
        with self._log.lock:
            status = Status.PLAYING if self._log.is_playing else Status.PAUSED
            if self._log.has_ended:
                status = Status.ENDED
            return Playback(status, int(self._log.at_s * 1e6), self._log.speed_ratio, self._log.n_jumps)

    def begin(self) -> None:
        """Play, unless a request came before."""
        with self._log.lock:
            if not self._is_begun:
                self._is_begun = True
                self._log.play()

    def apply(self, request: Request) -> Playback:
        """Apply a request within limits; return the new state."""
        with self._log.lock:
            self._is_begun = True
            self._log.set_speed(request.speed_after(self._log.speed_ratio))
            (self._log.play if request.is_play else self._log.pause)()
            if request.seek_us is not None:
                self._log.seek(request.seek_us / 1e6)
            return self.state
