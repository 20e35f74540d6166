"""Publish the commands of the keys until the user quits."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from typing import Protocol

from graphnav import Message, Stop, Twist
from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.live.teleop.drive import Drive
from graphnav.live.teleop.keys import Key, Keys

_LAST_ZEROS = 3
_STALLED_S = 0.3
"""Keys read later than this, because the process was suspended, are ignored..."""
_ALWAYS = {Key.HALT, Key.STOP, Key.QUIT}
"""... except these."""


class Keyboard(Protocol):
    """A source of key bytes."""

    def read(self, timeout_s: float) -> bytes | None:
        """Return the bytes typed, empty after the timeout, None at the end."""


class Session:
    """A keyboard driving session.

    ``show`` gets a line whenever the published command changes; it begins with the newest order, stop or arm.
    ``now_s`` is a monotonic clock, ``now_ns`` the time of day.
    """

    def __init__(
        self,
        bus: Bus,
        channel: str,
        stop_channel: str,
        drive: Drive,
        rate_hz: float,
        show: Callable[[str], None],
        now_s: Callable[[], float] = time.monotonic,
        now_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._bus, self._channel, self._stop_channel = bus, channel, stop_channel
        self._drive, self._period_s = drive, 1 / rate_hz
        self._show, self._now_s, self._now_ns = show, now_s, now_ns
        self._seqs: Counter[str] = Counter()
        self._is_sending = False
        self._order = self._shown = ""

    def run(self, keyboard: Keyboard) -> None:
        """Publish until the user quits or the keyboard ends; then publish zero if the robot was driving.

        Raises
        ------
        BusError
            The network refuses a message.
        """
        try:
            self._drive_by(keyboard)
        finally:
            for _ in range(_LAST_ZEROS if self._is_sending else 0):
                self._publish(self._channel, Twist(v_mps=0.0, omega_radps=0.0))

    def _drive_by(self, keyboard: Keyboard) -> None:
        decoder = Keys()
        due_s = self._now_s()
        while True:
            data = keyboard.read(due_s - self._now_s())
            now_s = self._now_s()
            if data is None:
                return
            keys = decoder.feed(data)
            if now_s - due_s > _STALLED_S:
                keys = [key for key in keys if key in _ALWAYS]
            for key in keys:
                if key is Key.QUIT:
                    return
                self._drive.press(key, now_s)
                if key in {Key.STOP, Key.ARM}:
                    self._publish(self._stop_channel, Stop(engaged=key is Key.STOP, reason="teleop"))
            if keys or now_s >= due_s:
                due_s = now_s + self._period_s
                self._command(now_s, keys)

    def _command(self, now_s: float, keys: list[Key]) -> None:
        twist = self._drive.command(now_s)
        self._is_sending = twist is not None
        if twist is not None:
            self._publish(self._channel, twist)
        said = f"{twist.v_mps:+.2f} m/s, {twist.omega_radps:+.2f} rad/s" if twist else "nothing"
        if Key.STOP in keys or Key.ARM in keys:
            self._order = "stop published; " if Key.STOP in keys else "armed again; "
        keys_give = f"keys give {self._drive.speed_mps:.2f} m/s, {self._drive.turn_radps:.2f} rad/s"
        line = f"{self._order}{keys_give}; publishing {said}"
        if line != self._shown:
            self._shown = line
            self._show(line)

    def _publish(self, channel: str, message: Message) -> None:
        self._bus.publish(channel, encode(message, self._now_ns() // 1000, self._seqs[channel]))
        self._seqs[channel] += 1
