"""Keyboard driving: keys of a terminal in, twists and stops out, with a dead man's timeout.

A terminal reports key presses, but not releases.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable
from enum import Enum, auto
from typing import Protocol

from graphnav import Message, Stop, Twist
from graphnav.core.bus import Bus
from graphnav.core.codec import encode
from graphnav.core.keyboard import KeyDecoder

HELP = """\
  w or i or up     forward        x  stop the robot until it is re-armed
  s or k or down   back           r  re-arm it
  a or j or left   turn left      +  faster
  d or l or right  turn right     -  slower
  space            halt           q  quit
"""
ZERO_S = 0.3
"""How long zero is published after the keys are released; then nothing is sent, and an override goes stale."""
_STEP_RATIO = 1.1
_LAST_ZEROS = 3
_STALLED_S = 0.3
"""Keys read later than this, because the process was suspended, are ignored..."""


class Key(Enum):
    """The meaning of a key."""

    FORWARD = auto()
    BACK = auto()
    LEFT = auto()
    RIGHT = auto()
    HALT = auto()
    FASTER = auto()
    SLOWER = auto()
    STOP = auto()
    ARM = auto()
    QUIT = auto()


_KEYS = {
    **dict.fromkeys(("w", "i", "up"), Key.FORWARD),
    **dict.fromkeys(("s", "k", "down"), Key.BACK),
    **dict.fromkeys(("a", "j", "left"), Key.LEFT),
    **dict.fromkeys(("d", "l", "right"), Key.RIGHT),
    **dict.fromkeys("+=", Key.FASTER),
    **dict.fromkeys("-_", Key.SLOWER),
    " ": Key.HALT,
    "x": Key.STOP,
    "r": Key.ARM,
    "q": Key.QUIT,
}


class Keys:
    """Decodes the bytes of a terminal; keys without a meaning are ignored."""

    def __init__(self) -> None:
        self._decoder = KeyDecoder()

    def feed(self, data: bytes) -> list[Key]:
        """Return the keys that ``data`` completes."""
        return [_KEYS[name] for name in self._decoder.feed(data) if name in _KEYS]


_V = {Key.FORWARD: 1.0, Key.BACK: -1.0}
_OMEGA = {Key.LEFT: 1.0, Key.RIGHT: -1.0}


class Drive:
    """The command of the keys pressed in the last ``timeout_s``; forward and turn have separate timeouts.

    ``speed_mps``, ``turn_radps``: speeds while a key is pressed; Key.FASTER and Key.SLOWER change both by a tenth.
    """

    def __init__(self, speed_mps: float, turn_radps: float, timeout_s: float) -> None:
        self.speed_mps, self.turn_radps = speed_mps, turn_radps
        self._timeout_s = timeout_s
        self._v = self._omega = (0.0, -math.inf)
        self._zero_until_s = -math.inf
        self._is_driving = False

    def press(self, key: Key, now_s: float) -> None:
        """Handle a key pressed, or repeated, at ``now_s``."""
        if key in _V:
            self._v = _V[key], now_s
        elif key in _OMEGA:
            self._omega = _OMEGA[key], now_s
        elif key in {Key.HALT, Key.STOP}:
            self._v = self._omega = (0.0, -math.inf)
            self._zero_until_s = now_s + ZERO_S
        elif key is Key.FASTER:
            self._scale(_STEP_RATIO)
        elif key is Key.SLOWER:
            self._scale(1 / _STEP_RATIO)
        if key in _V or key in _OMEGA:
            self._zero_until_s = now_s + self._timeout_s + ZERO_S

    def command(self, now_s: float) -> Twist | None:
        """Return the command to publish now, None for none; after a speed there is a zero, however late it is."""
        v, omega = (sign if now_s - at_s <= self._timeout_s else 0.0 for sign, at_s in (self._v, self._omega))
        was_driving, self._is_driving = self._is_driving, bool(v or omega)
        if self._is_driving:
            return Twist(v_mps=v * self.speed_mps, omega_radps=omega * self.turn_radps)
        return Twist(v_mps=0.0, omega_radps=0.0) if was_driving or now_s <= self._zero_until_s else None

    def _scale(self, ratio: float) -> None:
        self.speed_mps *= ratio
        self.turn_radps *= ratio


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
