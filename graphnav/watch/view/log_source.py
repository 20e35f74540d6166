"""Play a log for the page in a thread: pause, step, seek, speed."""

from __future__ import annotations

import threading
from pathlib import Path

from graphnav import Recording
from graphnav.core.record import LogCursor
from graphnav.watch.spy import Received
from graphnav.watch.view.watch import Watch

SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0)
_POLL_S = 0.02
_BEFORE_S = 10.0
"""The part of the log before the target of a jump that is played at once, to compute rates."""
_MAX_BEFORE = 20_000
_MAX_TOLD = 3


class LogSource:
    """Plays a log from its beginning once it is started; times are seconds from there.

    ``damage``: a description of the log's damage. ``recording``: the log at ``path``, if it is open already. Raises
    LogError if the file cannot be read.
    """

    def __init__(self, path: Path, recording: Recording | None = None) -> None:
        self.lock = threading.Lock()
        self.name = str(path)
        self.failure = ""
        self._recording = recording or Recording(path)
        lost = [
            *map(str, self._recording.damaged),
            *([str(self._recording.truncated)] if self._recording.truncated else []),
        ]
        self.damage = "; ".join(lost[:_MAX_TOLD]) + (f"; and {len(lost) - _MAX_TOLD} more" if lost[_MAX_TOLD:] else "")
        self._cursor = LogCursor(self._recording)
        self._cursor.pause()
        self.watch = Watch(self._now_s)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._play, name="graphnav-view", daemon=True)

    def dropped_packets(self) -> int:
        """Return 0: playing a log drops no packets."""
        return 0

    @property
    def n_events(self) -> int:
        """The number of events of the log."""
        return len(self._cursor)

    @property
    def length_s(self) -> float:
        """The time from the first event to the last."""
        return self._cursor.end_us / 1e6

    @property
    def at_s(self) -> float:
        """The playback time."""
        return self._cursor.at_us / 1e6

    @property
    def is_playing(self) -> bool:
        """Whether the playback time moves."""
        return not self._cursor.is_paused

    @property
    def speed_ratio(self) -> float:
        """Seconds of the log per second."""
        return self._cursor.speed_ratio

    def start(self) -> None:
        """Start playing."""
        self._cursor.resume()
        self._thread.start()

    def close(self) -> None:
        """Stop, and close the file."""
        self._closing.set()
        self._thread.join()
        self._recording.close()

    def play(self) -> None:
        """Continue; from the beginning if at the end. The caller holds the lock, here and below."""
        if self._cursor.is_at_end:
            self.seek(0.0)
        self._cursor.resume()

    def pause(self) -> None:
        """Pause."""
        self._cursor.pause()

    def set_speed(self, speed_ratio: float) -> None:
        """Continue at another speed."""
        self._cursor.set_speed(speed_ratio)

    def seek(self, at_s: float) -> None:
        """Jump to a time; the preceding messages in the rate window are played at once."""
        self._cursor.seek(at_s * 1e6)
        self._restart()

    def step(self, direction: int, channel: str | None) -> None:
        """Pause, and step to the next or previous message, of ``channel`` if the log has it."""
        self._cursor.pause()
        if self._cursor.step(direction, channel):
            self._restart()
        else:
            self._receive_due()

    def _play(self) -> None:
        while not self._closing.wait(_POLL_S):
            with self.lock:
                self._receive_due()
                if self._cursor.is_at_end:
                    self._cursor.pause()

    def _restart(self) -> None:
        """Begin to watch at the current time, with what a viewer needs of the past."""
        self.watch = Watch(self._now_s)
        self._cursor.due()
        recent = self._cursor.newest_since(self._cursor.at_us - _BEFORE_S * 1e6, _MAX_BEFORE)
        newest, poses = self._cursor.earlier(self._has_poses, recent[0] if recent else None)
        for number in (*sorted(newest | poses), *recent):
            self._receive(number)

    def _receive_due(self) -> None:
        for number in self._cursor.due():
            self._receive(number)

    def _has_poses(self, channel: str) -> bool:
        return self.watch.has_poses(self._recording.event(channel, 0).data)

    def _receive(self, number: int) -> None:
        event = self._recording.at(number)
        self.watch.receive(Received(event.channel, event.data, self._cursor.time_us(number) / 1e6))

    def _now_s(self) -> float:
        return self.at_s
