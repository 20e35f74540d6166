"""Play a log in a thread: play, pause, seek, speed."""

from __future__ import annotations

import threading
from pathlib import Path

from graphnav import Recording
from graphnav.core.codec import message_class_of
from graphnav.core.record import LogCursor
from graphnav.watch.export.entries.run_entries import MAX_UTIME
from graphnav.watch.export.log_pass import POSES
from graphnav.watch.view.foxglove.arrivals import Arrival, Arrivals
from graphnav.watch.view.foxglove.playback import Playback, Request, Status

_MAX_WAIT_S = 0.2
_BLOCK = 256
"""The maximum number of events handed over before requests are handled."""


class LogPlayer:
    """Plays a log, initially paused at its beginning; times are microseconds from there.

    ``begin_us`` is added to them for viewers: the timestamp of the first event, 0 if out of range for viewers. All
    methods are thread-safe. ``recording``: the log at ``path``, if it is open already.

    Raises LogError if the file cannot be read.
    """

    def __init__(self, path: Path, recording: Recording | None = None) -> None:
        self.name = str(path)
        self.failure = ""
        self.arrivals = Arrivals()
        self.recording = recording or Recording(path)
        self._cursor = LogCursor(self.recording)
        self._cursor.pause()
        self.duration_us = self._cursor.end_us
        first_us = self.recording.begin_us
        self.begin_us = first_us if 0 <= first_us < MAX_UTIME - self.duration_us else 0
        self._jumps = 0
        self._is_jump_due = True
        self._is_begun = False
        self._is_closing = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="graphnav-foxglove", daemon=True)

    @property
    def n_events(self) -> int:
        """The number of events of the log."""
        return len(self._cursor)

    @property
    def state(self) -> Playback:
        """The playback state."""
        with self._changed:
            return self._state()

    def start(self) -> None:
        """Start the thread, paused at the beginning."""
        self._thread.start()

    def close(self) -> None:
        """Stop, and close the file."""
        with self._changed:
            self._is_closing = True
            self._changed.notify()
        self._thread.join()
        self.recording.close()

    def begin(self) -> None:
        """Play, unless a request came before."""
        with self._changed:
            if not self._is_begun:
                self._is_begun = True
                self._cursor.resume()
                self._changed.notify()

    def apply(self, request: Request) -> Playback:
        """Apply a request within limits; return the new state."""
        with self._changed:
            self._is_begun = True
            seek_us = request.seek_us
            if seek_us is None and request.is_play and self._has_ended():
                seek_us = 0
            self._cursor.set_speed(request.speed_after(self._cursor.speed_ratio))
            if request.is_play != (not self._cursor.is_paused):
                (self._cursor.resume if request.is_play else self._cursor.pause)()
            if seek_us is not None:
                self._cursor.seek(seek_us)
                self._is_jump_due = True
                self._jumps += 1
            self._changed.notify()
            return self._state()

    def _state(self) -> Playback:
        status = Status.PAUSED if self._cursor.is_paused else Status.PLAYING
        if self._has_ended():
            status = Status.ENDED
        at_us = int(self._cursor.at_us)
        return Playback(status, at_us, self._cursor.speed_ratio, self._jumps)

    def _has_ended(self) -> bool:
        return not self._is_jump_due and self._cursor.is_at_end and not self._cursor.is_paused

    def _run(self) -> None:
        with self._changed:
            while not self._is_closing:
                if self._is_jump_due:
                    self._jump()
                numbers = self._cursor.due(_BLOCK)
                for number in numbers:
                    self.arrivals.put(self._arrival(number))
                self._changed.wait(0 if numbers else min(max(self._cursor.wait_s(), 0.0), _MAX_WAIT_S))

    def _jump(self) -> None:
        """Hand over the last message of each channel up to now, preceded by the poses of the path."""
        self._is_jump_due = False
        self._cursor.due()
        newest, poses = self._cursor.earlier(self._has_poses)
        arrivals = [self._arrival(number)._replace(is_past=True) for number in sorted(poses)]
        self.arrivals.jump(arrivals + [self._arrival(number) for number in sorted(newest)])

    def _has_poses(self, channel: str) -> bool:
        lcm_class = self.recording.channels[channel]
        return lcm_class is not None and message_class_of(lcm_class) in POSES

    def _arrival(self, number: int) -> Arrival:
        event = self.recording.at(number)
        return Arrival(event.channel, self.begin_us + self._cursor.time_us(number), event.data)
