"""Play a log in a thread: play, pause, seek, speed."""

from __future__ import annotations

import threading
from bisect import bisect_left, bisect_right
from pathlib import Path

from graphnav.core.codec import message_class_of
from graphnav.core.record import Recording
from graphnav.watch.export.entries.run_entries import MAX_UTIME
from graphnav.watch.export.log_pass import POSES
from graphnav.watch.player import PlaybackClock
from graphnav.watch.view.foxglove.arrivals import Arrival, Arrivals
from graphnav.watch.view.foxglove.playback import Playback, Request, Status

_MAX_POSES = 4000
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
        self._index = self.recording.index
        timeline = self.recording.timeline
        self._at_us = timeline.at_us
        self.duration_us = timeline.duration_us
        first_us = self.recording.begin_us
        self.begin_us = first_us if 0 <= first_us < MAX_UTIME - self.duration_us else 0
        self._pace = PlaybackClock()
        self._pace.pause()
        self._next = self._jumps = 0
        self._is_jump_due = True
        self._is_begun = False
        self._is_closing = False
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="graphnav-foxglove", daemon=True)

    @property
    def n_events(self) -> int:
        """The number of events of the log."""
        return len(self._at_us)

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
                self._pace.seek(self._pace.at_us)
                self._pace.resume()
                self._changed.notify()

    def apply(self, request: Request) -> Playback:
        """Apply a request within limits; return the new state."""
        with self._changed:
            self._is_begun = True
            seek_us = request.seek_us
            if seek_us is None and request.is_play and self._has_ended():
                seek_us = 0
            self._pace.set_speed(request.speed_after(self._pace.speed_ratio))
            if request.is_play != (not self._pace.is_paused):
                (self._pace.resume if request.is_play else self._pace.pause)()
            if seek_us is not None:
                self._pace.seek(min(max(seek_us, 0), self.duration_us))
                self._is_jump_due = True
                self._jumps += 1
            self._changed.notify()
            return self._state()

    def _state(self) -> Playback:
        status = Status.PAUSED if self._pace.is_paused else Status.PLAYING
        if self._has_ended():
            status = Status.ENDED
        at_us = int(min(self._pace.at_us, self.duration_us))
        return Playback(status, at_us, self._pace.speed_ratio, self._jumps)

    def _has_ended(self) -> bool:
        return not self._is_jump_due and self._next >= len(self._at_us) and not self._pace.is_paused

    def _run(self) -> None:
        with self._changed:
            while not self._is_closing:
                if self._is_jump_due:
                    self._jump(self._pace.at_us)
                end = min(bisect_right(self._at_us, self._pace.at_us), self._next + _BLOCK)
                for number in range(self._next, end):
                    self.arrivals.put(self._arrival(number))
                if end > self._next:
                    self._next = end
                    self._changed.wait(0)
                else:
                    self._changed.wait(self._wait_s())

    def _wait_s(self) -> float:
        if self._pace.is_paused or self._next >= len(self._at_us):
            return _MAX_WAIT_S
        return min(max(self._pace.wait_s(self._at_us[self._next]), 0.0), _MAX_WAIT_S)

    def _jump(self, at_us: float) -> None:
        """Hand over the last message of each channel up to a time, preceded by the poses of the path."""
        self._is_jump_due = False
        self._next = bisect_right(self._at_us, at_us)
        past: set[int] = set()
        newest: set[int] = set()
        for channel, numbers in self._index.channels.items():
            place = bisect_left(numbers, self._next)
            if not place:
                continue
            newest.add(numbers[place - 1])
            lcm_class = self.recording.channels[channel]
            if lcm_class is not None and message_class_of(lcm_class) in POSES:
                past.update(numbers[0 : place - 1 : max(1, place // _MAX_POSES)])
        arrivals = [self._arrival(number)._replace(is_past=True) for number in sorted(past - newest)]
        self.arrivals.jump(arrivals + [self._arrival(number) for number in sorted(newest)])

    def _arrival(self, number: int) -> Arrival:
        event = self.recording.at(number)
        return Arrival(event.channel, self.begin_us + self._at_us[number], event.data)
