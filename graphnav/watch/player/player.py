"""Publish the messages of a log when they are due; keys pause, step, seek and change the speed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Protocol

from graphnav.core.errors import BusError
from graphnav.core.keyboard import KeyDecoder
from graphnav.core.record import Event
from graphnav.watch.player.playback_clock import PlaybackClock
from graphnav.watch.player.select_events import EventSelection

HELP = "keys: space pause, n next message, left/right 5 s, -/+ speed, q quit"

_SEEK_US = 5e6
_FASTER_RATIO = 2.0
_MAX_SPEED_RATIO = 1024.0
_MAX_LATE_S = 0.5
"""Beyond this delay the schedule is shifted instead of caught up: receivers would lose a burst."""
_REFRESH_S = 0.2
_BURST_BYTES = 65_536
_BREATH_S, _BREATH_LATE_S = 0.002, 0.05
"""The pause after a burst, unless playback is late: default receive buffers hold three packets."""
_MIN_ROUND_S = 0.1
"""A log with a single timestamp must not flood the network when it is looped."""


class Keyboard(Protocol):
    """A source of keys."""

    def read(self, timeout_s: float) -> bytes | None:
        """Return the typed keys, empty after a timeout, None at the end of the input."""


class Player:
    """Plays the events of ``selection``: reads each with ``read`` and publishes it with ``send``.

    ``notice`` is called when playback is more than half a second late, and again each time the delay has doubled.
    ``show`` is called five times a second. ``loop`` restarts at the end.
    """

    def __init__(
        self,
        selection: EventSelection,
        read: Callable[[int], Event],
        send: Callable[[str, bytes], None],
        pace: PlaybackClock,
        *,
        loop: bool = False,
        notice: Callable[[str], None] = lambda _: None,
        show: Callable[[], None] = lambda: None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.pace = pace
        self.n_played = self.n_refused = 0
        """Messages published, and refused by LCM."""
        self.refusal = ""
        """Why the first one was refused by LCM."""
        self.behind_s = 0.0
        """Accumulated delay, seconds."""
        self._chosen, self._read, self._send, self._loop = selection, read, send, loop
        self._notice, self._show, self._now_s = notice, show, now_s
        self._next = 0
        self._burst_bytes = 0
        self._breath_until_s = self._round_until_s = self._looked_s = self._shown_s = now_s()
        self._noticed_s = _MAX_LATE_S / 2

    def play(self, keyboard: Keyboard) -> None:
        """Play to the end, or until the user quits or the keyboard ends."""
        decoder = KeyDecoder()
        self._begin_round()
        while True:
            wait_s = self._wait_s()
            if wait_s > 0 or self._now_s() - self._looked_s > _REFRESH_S:
                self._burst_bytes = 0
                data = keyboard.read(min(max(0.0, wait_s), _REFRESH_S))
                self._looked_s = self._now_s()
                if data is None or not all(map(self._press, decoder.feed(data))):
                    return
                self._refresh()
            elif self._next < len(self._chosen.numbers):
                self._play_next()
            elif self._loop:
                self._begin_round()
            else:
                return

    def _begin_round(self) -> None:
        self._next = 0
        self._round_until_s = self._now_s() + _MIN_ROUND_S
        self.pace.seek(self._chosen.begin_us)

    def _wait_s(self) -> float:
        """Return the seconds until the next event or refresh."""
        if self._next < len(self._chosen.numbers):
            return max(self.pace.wait_s(self._chosen.at_us[self._next]), self._breath_until_s - self._now_s())
        if not self._loop:
            return math.inf if self.pace.is_paused else 0.0
        return max(self.pace.wait_s(self._chosen.end_us), self._round_until_s - self._now_s())

    def _play_next(self) -> None:
        at_us = self._chosen.at_us[self._next]
        late_s = -self.pace.wait_s(at_us)
        if late_s > _MAX_LATE_S:
            self._give_up(at_us, late_s)
        self._publish()
        if self._burst_bytes >= _BURST_BYTES and late_s < _BREATH_LATE_S:
            self._burst_bytes = 0
            self._breath_until_s = self._now_s() + _BREATH_S

    def _give_up(self, at_us: int, late_s: float) -> None:
        """Continue from here; call ``notice`` when the delay has doubled."""
        self.pace.seek(at_us)
        self.behind_s += late_s
        if self.behind_s >= 2 * self._noticed_s:
            self._noticed_s = self.behind_s
            self._notice(f"cannot keep up with {self.pace.speed_ratio:g}x: {self.behind_s:.1f} s behind")

    def _publish(self) -> None:
        event = self._read(self._chosen.numbers[self._next])
        self._next += 1
        self._burst_bytes += len(event.data)
        try:
            self._send(event.channel, event.data)
            self.n_played += 1
        except BusError as error:
            self.n_refused += 1
            self.refusal = self.refusal or str(error)

    def _press(self, key: str) -> bool:
        """Handle a key; return whether to continue."""
        pace = self.pace
        if key == " ":
            (pace.resume if pace.is_paused else pace.pause)()
        elif key == "n":
            pace.pause()
            self._step()
        elif key in {"left", "right"}:
            self._seek(pace.at_us + (_SEEK_US if key == "right" else -_SEEK_US))
        elif key in {"+", "="}:
            pace.set_speed(min(_MAX_SPEED_RATIO, pace.speed_ratio * _FASTER_RATIO))
        elif key in {"-", "_"}:
            pace.set_speed(max(1 / _MAX_SPEED_RATIO, pace.speed_ratio / _FASTER_RATIO))
        self._shown_s = -1.0
        return key != "q"

    def _step(self) -> None:
        """Publish the next message, and all others with the same timestamp."""
        if self._next == len(self._chosen.numbers):
            return
        at_us = self._chosen.at_us[self._next]
        while self._next < len(self._chosen.numbers) and self._chosen.at_us[self._next] == at_us:
            self._publish()
        self.pace.seek(at_us)

    def _seek(self, at_us: float) -> None:
        at_us = min(max(at_us, self._chosen.begin_us), self._chosen.end_us)
        self.pace.seek(at_us)
        self._next = self._chosen.first_at(at_us)

    def _refresh(self) -> None:
        if self._now_s() - self._shown_s >= _REFRESH_S or self._shown_s < 0:
            self._shown_s = self._now_s()
            self._show()
