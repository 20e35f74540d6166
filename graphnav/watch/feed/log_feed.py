"""A thread that plays a log: play, pause, step, seek, speed."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import NamedTuple

from graphnav import Odometry, State
from graphnav.core.codec import message_class_of
from graphnav.watch.feed.feed import Feed, Received
from graphnav.watch.log_cursor import LogCursor

_MAX_WAIT_S = 0.2
_BLOCK = 256
"""The maximum number of messages that are handed over before others may use the lock."""
_MAX_BEFORE = 20_000


class Past(NamedTuple):
    """The messages before another time of a log, as a viewer that begins there needs them.

    ``poses``: of the robot's path, thinned; ``newest``: the last message of each channel, oldest first, with all of the
    last seconds if they are wanted. Both are read from the file while they are iterated, once.
    """

    poses: Iterator[Received]
    newest: Iterator[Received]


class LogFeed:
    """Plays a log from its beginning, initially paused; times are seconds since its first event.

    ``take`` is called with each message that is due, ``jump`` with what went before the new time after a jump, both
    with ``lock`` held. ``before_s``: how many of the seconds before it `Past` holds completely, for rates. All methods
    may be called from any thread; with ``lock`` held several are one.

    Raises LogError if the file cannot be read, GraphnavError if the log is empty.
    """

    failure = losses = ""

    def __init__(
        self,
        feed: Feed,
        take: Callable[[Received], None],
        jump: Callable[[Past], None],
        before_s: float = 0.0,
        name: str = "graphnav-feed",
    ) -> None:
        self.name = feed.name
        self.recording = feed.open_log()
        if not self.recording.n_events:
            raise feed.silence(None)
        self.lock = threading.Condition()
        self.n_jumps = 0
        self._take, self._jump, self._before_s = take, jump, before_s
        self._cursor = LogCursor(self.recording)
        self._cursor.pause()
        self._is_closing = False
        self._thread = threading.Thread(target=self._play, name=name, daemon=True)

    def dropped_packets(self) -> int:
        """Return 0: playing a log drops no packets."""
        return 0

    @property
    def length_s(self) -> float:
        """The time from the first event to the last."""
        return self._cursor.end_us / 1e6

    @property
    def at_s(self) -> float:
        """The playback time."""
        with self.lock:
            return self._cursor.at_us / 1e6

    @property
    def is_playing(self) -> bool:
        """Whether the playback time moves."""
        return not self._cursor.is_paused

    @property
    def has_ended(self) -> bool:
        """Whether the last message was handed over."""
        return self._cursor.is_at_end

    @property
    def speed_ratio(self) -> float:
        """Seconds of the log per second."""
        return self._cursor.speed_ratio

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """Stop, and close the file."""
        with self.lock:
            self._is_closing = True
            self.lock.notify()
        if self._thread.is_alive():
            self._thread.join()
        self.recording.close()

    def play(self) -> None:
        """Continue; from the beginning if at the end."""
        with self.lock:
            if self.has_ended:
                self.seek(0.0)
            self._cursor.resume()
            self.lock.notify()

    def pause(self) -> None:
        """Pause."""
        with self.lock:
            self._cursor.pause()

    def set_speed(self, speed_ratio: float) -> None:
        """Continue at another speed."""
        with self.lock:
            self._cursor.set_speed(speed_ratio)
            self.lock.notify()

    def seek(self, at_s: float) -> None:
        """Jump to a time within the log."""
        with self.lock:
            self._cursor.seek(at_s * 1e6)
            self._hand_past()
            self.lock.notify()

    def step(self, direction: int, channel: str | None) -> None:
        """Pause, and step to the next or previous message, of ``channel`` if the log has it."""
        with self.lock:
            self._cursor.pause()
            if self._cursor.step(direction, channel):
                self._hand_past()
            else:
                self._hand_due()

    def _play(self) -> None:
        with self.lock:
            while not self._is_closing:
                is_more = self._hand_due(_BLOCK)
                if self.has_ended:
                    self._cursor.pause()
                self.lock.wait(0 if is_more else min(max(self._cursor.wait_s(), 0.0), _MAX_WAIT_S))

    def _hand_due(self, max_events: int | None = None) -> bool:
        """Hand over what is due; return whether there was any."""
        numbers = self._cursor.due(max_events)
        for received in map(self._received, numbers):
            self._take(received)
        return bool(numbers)

    def _hand_past(self) -> None:
        self.n_jumps += 1
        self._cursor.due()
        since_us = self._cursor.at_us - self._before_s * 1e6
        recent = self._cursor.newest_since(since_us, _MAX_BEFORE) if self._before_s else ()
        newest, poses = self._cursor.earlier(self._has_poses, recent[0] if recent else None)
        self._jump(Past(map(self._received, sorted(poses)), map(self._received, (*sorted(newest), *recent))))

    def _has_poses(self, channel: str) -> bool:
        lcm_class = self.recording.channels[channel]
        return lcm_class is not None and message_class_of(lcm_class) in {State, Odometry}

    def _received(self, number: int) -> Received:
        event = self.recording.at(number)
        return Received(event.channel, event.data, self._cursor.time_us(number) / 1e6)
