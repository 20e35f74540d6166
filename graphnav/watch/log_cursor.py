"""A position in a log that moves by a clock: play, pause, seek, step, speed, loop."""

from __future__ import annotations

import math
import time
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from itertools import chain

from graphnav import Recording
from graphnav.core.record import ChannelFilter, Event

_MIN_ROUND_S = 0.1
"""A log with a single timestamp must not flood its listeners when it is looped."""
_MAX_TRACK = 4000


class LogCursor:
    """A position in the selected events of a log, and the clock that moves it.

    Times are microseconds since the log's first event, with timestamps that jump corrected by `Timeline`. Log time is
    derived from a monotonic clock relative to one anchor, so that delays do not accumulate. The cursor stands before
    its next event: what is ``due`` at the current log time is handed out once, in the order of the file. It plays from
    its beginning, unless it is paused. Not thread-safe.

    ``channels``: selects events by channel, None for all; ``begin_us`` and ``end_us`` (None: the end of the log) select
    them by time, both inclusive. ``loop``: begin again at the end. ``now_s``: the monotonic clock.
    """

    def __init__(
        self,
        recording: Recording,
        channels: ChannelFilter | None = None,
        begin_us: int = 0,
        end_us: int | None = None,
        *,
        loop: bool = False,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.recording = recording
        self._times_us = recording.timeline.at_us
        last_us = recording.timeline.duration_us
        self.begin_us, self.end_us = begin_us, last_us if end_us is None else min(last_us, end_us)
        first, stop = bisect_left(self._times_us, begin_us), bisect_right(self._times_us, self.end_us)
        self._numbers: Sequence[int] = range(first, stop)
        places = {
            name: numbers[bisect_left(numbers, first) : bisect_left(numbers, stop)]
            for name, numbers in recording.index.channels.items()
            if channels is None or channels.takes(name)
        }
        self._places: dict[str, Sequence[int]] = {name: numbers for name, numbers in places.items() if numbers}
        if sum(map(len, self._places.values())) < len(self._numbers):
            self._numbers = array("q", sorted(chain.from_iterable(self._places.values())))
        self.is_paused = False
        self._loop, self._now_s = loop, now_s
        self._next = 0
        self._speed_ratio = 1.0
        self._anchor_us, self._anchor_s = float(begin_us), now_s()
        self._round_until_s = self._anchor_s + _MIN_ROUND_S

    def __len__(self) -> int:
        return len(self._numbers)

    @property
    def channels(self) -> frozenset[str]:
        """The channels of the selected events."""
        return frozenset(self._places)

    @property
    def speed_ratio(self) -> float:
        """Seconds of the log per second."""
        return self._speed_ratio

    @property
    def at_us(self) -> float:
        """The current log time, within the selection."""
        elapsed_s = 0.0 if self.is_paused else self._now_s() - self._anchor_s
        return min(max(self._anchor_us + elapsed_s * 1e6 * self._speed_ratio, self.begin_us), self.end_us)

    def pause(self) -> None:
        """Stop the clock."""
        self.set_clock(self.at_us)
        self.is_paused = True

    def resume(self) -> None:
        """Restart the clock."""
        self.set_clock(self.at_us)
        self.is_paused = False

    def set_speed(self, speed_ratio: float) -> None:
        """Continue at another speed."""
        self.set_clock(self.at_us)
        self._speed_ratio = speed_ratio

    def set_clock(self, at_us: float) -> None:
        """Set the log time; events up to it are due, and none is taken back."""
        self._anchor_us, self._anchor_s = at_us, self._now_s()

    @property
    def is_at_end(self) -> bool:
        """Whether the last event was handed out."""
        return self._next >= len(self._numbers)

    @property
    def has_ended(self) -> bool:
        """Whether nothing more will be due before a seek."""
        return self.is_at_end and not self._loop

    def seek(self, at_us: float) -> None:
        """Move to a time within the selection, before its events."""
        at_us = round(min(max(at_us, self.begin_us), self.end_us))
        self.set_clock(at_us)
        self._next = bisect_left(self._numbers, at_us, key=self._times_us.__getitem__)

    def wait_s(self) -> float:
        """Return the seconds until the next event is due, negative if it is late, infinite if there will be none."""
        if not self.is_at_end:
            return self._wait_s(self._times_us[self._numbers[self._next]])
        if not self._loop:
            return math.inf
        return max(self._wait_s(self.end_us), self._round_until_s - self._now_s())

    def due(self, max_events: int | None = None) -> Sequence[int]:
        """Hand out the numbers of the events that are due, at most ``max_events``; a loop begins again at the end."""
        if self.is_at_end and self._loop and self.wait_s() <= 0:
            self._round_until_s = self._now_s() + _MIN_ROUND_S
            self.seek(self.begin_us)
        begin = self._next
        stop = bisect_right(self._numbers, round(self.at_us), key=self._times_us.__getitem__)
        self._next = max(begin, stop if max_events is None else min(stop, begin + max_events))
        return self._numbers[begin : self._next]

    def step(self, count: int, channel: str | None = None) -> bool:
        """Move to the time of another message, of ``channel`` if the log has it; return whether that is a seek back.

        ``count``: 1 for the next message that was not handed out, -1 for the one before the newest that was. Forward,
        only the clock is set: what lies between becomes due. Back, the messages of that time become due again.
        """
        numbers = self._places.get(channel or "") or self._numbers
        newest = self._n_before(numbers) - 1
        target = min(max(newest + count, 0), len(numbers) - 1)
        if count > 0:
            if target > newest:
                self.set_clock(self._times_us[numbers[target]])
            return False
        while target > 0 and newest >= 0 and self._times_us[numbers[target]] == self._times_us[numbers[newest]]:
            target -= 1
        at_us = self._times_us[numbers[target]] if target >= 0 else self.begin_us
        if at_us >= round(self.at_us):
            return False
        self.seek(at_us)
        return True

    def time_us(self, number: int) -> int:
        """Return the time of an event."""
        return self._times_us[number]

    def event(self, number: int) -> Event:
        """Return an event by its number in the log."""
        return self.recording.at(number)

    @property
    def next_us(self) -> int:
        """The time of the next event, the end after the last."""
        return self.end_us if self.is_at_end else self._times_us[self._numbers[self._next]]

    def newest(self, channel: str, n: int = 1) -> Sequence[int]:
        """Return the last ``n`` events of a channel that were handed out, fewer near its beginning."""
        numbers = self._places.get(channel, ())
        stop = self._n_before(numbers)
        return numbers[max(0, stop - n) : stop]

    def newest_since(self, begin_us: float, max_events: int) -> Sequence[int]:
        """Return the events from a time up to the position, at most the newest ``max_events``."""
        first = bisect_left(self._numbers, begin_us, key=self._times_us.__getitem__)
        return self._numbers[max(first, self._next - max_events) : self._next]

    def earlier(self, is_track: Callable[[str], bool], number: int | None = None) -> tuple[set[int], set[int]]:
        """Return what a viewer that starts at an event, or at the position, needs of those before it.

        These are the newest event of each channel, and at most 4000 spread over all that went before of each channel
        for which ``is_track`` holds, such as the poses of a path.
        """
        newest, track = set[int](), set[int]()
        for channel, numbers in self._places.items():
            place = self._n_before(numbers) if number is None else bisect_left(numbers, number)
            if not place:
                continue
            newest.add(numbers[place - 1])
            if is_track(channel):
                track.update(numbers[0 : place - 1 : max(1, place // _MAX_TRACK)])
        return newest, track - newest

    def _n_before(self, numbers: Sequence[int]) -> int:
        """Return how many of some events are before the position."""
        return len(numbers) if self.is_at_end else bisect_left(numbers, self._numbers[self._next])

    def _wait_s(self, at_us: float) -> float:
        if self.is_paused:
            return math.inf
        return self._anchor_s + (at_us - self._anchor_us) / 1e6 / self._speed_ratio - self._now_s()
