"""Publish the messages of a log when they are due; keys pause, step, seek and change the speed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from graphnav import GraphnavError, Place, Recording, UserError, did_you_mean
from graphnav.core.errors import BusError, LogError, shown_name
from graphnav.core.keyboard import KeyDecoder
from graphnav.core.record import ChannelFilter
from graphnav.watch.log_cursor import LogCursor

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


class Keyboard(Protocol):
    """A source of keys."""

    def read(self, timeout_s: float) -> bytes | None:
        """Return the typed keys, empty after a timeout, None at the end of the input."""


class Player:
    """Plays the events of ``cursor`` from its position: publishes each with ``send``.

    ``notice`` is called when playback is more than half a second late, and again each time the delay has doubled.
    ``show`` is called five times a second.
    """

    def __init__(
        self,
        cursor: LogCursor,
        send: Callable[[str, bytes], None],
        *,
        notice: Callable[[str], None] = lambda _: None,
        show: Callable[[], None] = lambda: None,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self.cursor = cursor
        self.n_played = self.n_refused = 0
        """Messages published, and refused by LCM."""
        self.refusal = ""
        """Why the first one was refused by LCM."""
        self.behind_s = 0.0
        """Accumulated delay, seconds."""
        self._send, self._notice, self._show, self._now_s = send, notice, show, now_s
        self._burst_bytes = 0
        self._breath_until_s = self._looked_s = self._shown_s = now_s()
        self._noticed_s = _MAX_LATE_S / 2

    def play(self, keyboard: Keyboard) -> None:
        """Play to the end, or until the user quits or the keyboard ends."""
        decoder = KeyDecoder()
        self.cursor.seek(self.cursor.begin_us)
        while self.cursor.is_paused or not self.cursor.has_ended:
            wait_s = max(self.cursor.wait_s(), self._breath_until_s - self._now_s())
            if wait_s > 0 or self._now_s() - self._looked_s > _REFRESH_S:
                self._burst_bytes = 0
                data = keyboard.read(min(max(0.0, wait_s), _REFRESH_S))
                self._looked_s = self._now_s()
                if data is None or not all(map(self._press, decoder.feed(data))):
                    return
                self._refresh()
            else:
                self._play_next()

    def _play_next(self) -> None:
        late_s = 0.0 if self.cursor.is_at_end else -self.cursor.wait_s()
        if late_s > _MAX_LATE_S:
            self._give_up(late_s)
        self._publish(1)
        if self._burst_bytes >= _BURST_BYTES and late_s < _BREATH_LATE_S:
            self._burst_bytes = 0
            self._breath_until_s = self._now_s() + _BREATH_S

    def _give_up(self, late_s: float) -> None:
        """Continue from here; call ``notice`` when the delay has doubled."""
        self.cursor.set_clock(self.cursor.next_us)
        self.behind_s += late_s
        if self.behind_s >= 2 * self._noticed_s:
            self._noticed_s = self.behind_s
            self._notice(f"cannot keep up with {self.cursor.speed_ratio:g}x: {self.behind_s:.1f} s behind")

    def _publish(self, max_events: int | None = None) -> None:
        """Publish the messages that are due."""
        for number in self.cursor.due(max_events):
            event = self.cursor.recording.at(number)
            self._burst_bytes += len(event.data)
            try:
                self._send(event.channel, event.data)
                self.n_played += 1
            except BusError as error:
                self.n_refused += 1
                self.refusal = self.refusal or str(error)

    def _press(self, key: str) -> bool:
        """Handle a key; return whether to continue."""
        cursor = self.cursor
        if key == " ":
            (cursor.resume if cursor.is_paused else cursor.pause)()
        elif key == "n":
            cursor.pause()
            cursor.step(1)
            self._publish()  # all of one timestamp
        elif key in {"left", "right"}:
            cursor.seek(cursor.at_us + (_SEEK_US if key == "right" else -_SEEK_US))
        elif key in {"+", "="}:
            cursor.set_speed(min(_MAX_SPEED_RATIO, cursor.speed_ratio * _FASTER_RATIO))
        elif key in {"-", "_"}:
            cursor.set_speed(max(1 / _MAX_SPEED_RATIO, cursor.speed_ratio / _FASTER_RATIO))
        self._shown_s = -1.0
        return key != "q"

    def _refresh(self) -> None:
        if self._now_s() - self._shown_s >= _REFRESH_S or self._shown_s < 0:
            self._shown_s = self._now_s()
            self._show()


def select_events(
    recording: Recording,
    channels: ChannelFilter,
    start_s: float = 0.0,
    end_s: float | None = None,
    *,
    loop: bool = False,
) -> LogCursor:
    """Return a cursor over the channels from ``start_s`` to ``end_s`` (None: the end), seconds since the first event.

    Raises
    ------
    UserError
        The selection is empty, or the range is outside the log.
    GraphnavError
        The log is empty.
    """
    if not recording.n_events:
        why = f"; {recording.truncated}" if recording.truncated else ""
        raise GraphnavError(f"{recording.path} holds no messages{why}")
    duration_s = recording.timeline.duration_us / 1e6
    if start_s > duration_s:
        raise UserError.of(f"{start_s:g} s is after the end: the log is {duration_s:g} s long", "", Place("--start"))
    if end_s is not None and end_s < start_s:
        raise UserError.of(f"{end_s:g} s is before --start {start_s:g}", "give a later end", Place("--end"))
    end_us = None if end_s is None else round(end_s * 1e6)
    cursor = LogCursor(recording, channels, round(start_s * 1e6), end_us, loop=loop)
    if not len(cursor):
        raise _nothing(recording, channels)
    return cursor


def _nothing(recording: Recording, channels: ChannelFilter) -> UserError:
    names = recording.index.channels.keys()
    if any(map(channels.takes, names)):
        return UserError.of(
            f"{recording.path} holds no selected messages in this time range", "give another --start or --end"
        )
    known = {shown_name(name) for name in names}
    guesses = (did_you_mean(pattern, known) for pattern in channels.patterns)
    hint = next(filter(None, guesses), f"channels are {', '.join(sorted(known))}")
    return UserError.of(f"{recording.path} holds no channel that matches the filters", hint)


def motor_channels(recording: Recording) -> dict[str, str]:
    """Return the motor channels of the graph that produced a log, each with its output.

    Empty if the log does not hold its graph.
    """
    try:
        outputs = recording.graph.get("outputs")
    except LogError:
        return {}
    found = {}
    for ref, output in outputs.items() if isinstance(outputs, dict) else ():
        if isinstance(output, dict) and output.get("motor") is True and isinstance(output.get("channel"), str):
            found[output["channel"]] = str(ref)
    return found
