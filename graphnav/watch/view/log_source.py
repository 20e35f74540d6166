"""Play a log in a thread: pause, step, seek, speed."""

from __future__ import annotations

import threading
import time
from bisect import bisect_left, bisect_right
from pathlib import Path

from graphnav.core.record import Recording
from graphnav.watch.spy import Received
from graphnav.watch.view.watch import Watch

SPEEDS = (0.25, 0.5, 1.0, 2.0, 5.0)
_POLL_S = 0.02
_BEFORE_S = 10.0
"""The part of the log before the target of a jump that is played at once, to compute rates."""
_MAX_BEFORE = 20_000
_MAX_POSES = 4000
_MAX_TOLD = 3


class LogSource:
    """Plays a log from its beginning; times are seconds from there.

    Timestamps that jump are corrected by `Timeline`. ``damage``: a description of the log's damage.
    ``recording``: the log at ``path``, if it is open already. Raises LogError if the file cannot be read.
    """

    def __init__(self, path: Path, recording: Recording | None = None) -> None:
        self.lock = threading.Lock()
        self.name = str(path)
        self.failure = ""
        self._recording = recording or Recording(path)
        self._index = self._recording.index
        self._times_us = self._recording.timeline.at_us
        lost = [
            *map(str, self._recording.damaged),
            *([str(self._recording.truncated)] if self._recording.truncated else []),
        ]
        self.damage = "; ".join(lost[:_MAX_TOLD]) + (f"; and {len(lost) - _MAX_TOLD} more" if lost[_MAX_TOLD:] else "")
        self.speed_ratio = 1.0
        self.is_playing = True
        self._at_s = 0.0
        self._next = 0
        self.watch = Watch(self._now)
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._play, name="graphnav-view", daemon=True)

    def dropped_packets(self) -> int:
        """Return 0: playing a log drops no packets."""
        return 0

    @property
    def n_events(self) -> int:
        """The number of events of the log."""
        return len(self._times_us)

    @property
    def length_s(self) -> float:
        """The time from the first event to the last."""
        return self._times_us[-1] / 1e6 if self._times_us else 0.0

    @property
    def at_s(self) -> float:
        """The playback time."""
        return self._at_s

    def start(self) -> None:
        """Start playing."""
        self._thread.start()

    def close(self) -> None:
        """Stop, and close the file."""
        self._closing.set()
        self._thread.join()
        self._recording.close()

    def play(self) -> None:
        """Continue; from the beginning if at the end. The caller holds the lock, here and below."""
        if self._next >= len(self._times_us):
            self.seek(0.0)
        self.is_playing = True

    def pause(self) -> None:
        """Pause."""
        self.is_playing = False

    def seek(self, at_s: float) -> None:
        """Jump to a time; the preceding messages in the rate window are played at once."""
        at_s = min(max(at_s, 0.0), self.length_s)
        self._at_s = at_s
        self.watch = Watch(self._now)
        end = bisect_right(self._times_us, self._us(at_s))
        first = max(bisect_left(self._times_us, self._us(at_s - _BEFORE_S)), end - _MAX_BEFORE)
        for number in self._wanted_before(first):
            self._receive(number)
        for number in range(first, end):
            self._receive(number)
        self._next = end

    def step(self, direction: int, channel: str | None) -> None:
        """Pause, and step to the next or previous message, of ``channel`` if the log has it."""
        self.is_playing = False
        numbers = self._index.channels.get(channel or "") or range(len(self._times_us))
        if direction > 0:
            place = bisect_left(numbers, self._next)
            if place < len(numbers):
                self._advance(self._times_us[numbers[place]])
        else:
            here = bisect_left(numbers, self._next) - 1
            before = here - 1
            while before >= 0 and self._times_us[numbers[before]] == self._times_us[numbers[here]]:
                before -= 1
            if before >= 0:
                self.seek(self._times_us[numbers[before]] / 1e6)

    def _play(self) -> None:
        before_s = time.monotonic()
        while not self._closing.wait(_POLL_S):
            now_s = time.monotonic()
            with self.lock:
                if self.is_playing:
                    self._advance(self._us(self._at_s + (now_s - before_s) * self.speed_ratio))
                    self.is_playing = self._next < len(self._times_us)
            before_s = now_s

    def _advance(self, to_us: int) -> None:
        end = bisect_right(self._times_us, to_us)
        self._at_s = min(to_us / 1e6, self.length_s)
        for number in range(self._next, end):
            self._receive(number)
        self._next = end

    def _wanted_before(self, first: int) -> list[int]:
        """Return the last event of each channel before ``first``, and the poses of the path up to there."""
        wanted: set[int] = set()
        for channel, numbers in self._index.channels.items():
            place = bisect_left(numbers, first)
            if not place:
                continue
            wanted.add(numbers[place - 1])
            if self.watch.has_poses(self._recording.event(channel, 0).data):
                wanted.update(numbers[0 : place : max(1, place // _MAX_POSES)])
        return sorted(wanted)

    def _receive(self, number: int) -> None:
        event = self._recording.at(number)
        self.watch.receive(Received(event.channel, event.data, self._times_us[number] / 1e6))

    def _us(self, at_s: float) -> int:
        return round(at_s * 1e6)

    def _now(self) -> float:
        return self._at_s
