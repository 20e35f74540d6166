"""Record the messages of a group of motor channels, with their times of arrival."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from graphnav.core.bus import Bus
from graphnav.core.codec import decode, encode
from graphnav.core.messages import Twist
from graphnav.live.motors.sender import MotorChannel

LIMIT_S = 30.0
"""How long anything may take: a loaded machine is slow, a failure should not hang."""
GO_MPS = 0.5


class Heard(NamedTuple):
    """A message: when it came (monotonic seconds), on which channel, its stamp, number and speed."""

    at_s: float
    channel: str
    utime: int
    seq: int
    v_mps: float

    @property
    def is_stop(self) -> bool:
        return self.v_mps == 0.0


class Listener:
    """Another program on the group: a thread that writes down what comes on some channels."""

    def __init__(self, url: str, *channels: str) -> None:
        self.heard: list[Heard] = []
        self._bus = Bus(url)
        for channel in channels:
            self._bus.subscribe(channel, self._hear)
        self._more = threading.Condition()
        self._is_closing = False
        self._thread = threading.Thread(target=self._listen)
        self._thread.start()

    def wait_for(self, enough: Callable[[list[Heard]], object]) -> None:
        """Wait until what was heard is enough."""
        with self._more:
            assert self._more.wait_for(lambda: enough(self.heard), LIMIT_S), self.heard[-60:]

    def wait_for_count(self, count: int) -> None:
        """Wait until so many messages were heard."""
        self.wait_for(lambda heard: len(heard) >= count)

    def wait_for_stops(self, channel: str = "", count: int = 20) -> None:
        """Wait for some stops; of the 50 in a second a loaded machine may send fewer."""
        self.wait_for(lambda _: len(self.stops(channel)) >= count)

    def commands(self, channel: str = "") -> list[Heard]:
        """Return the messages that let the robot go."""
        return [heard for heard in self.heard if not heard.is_stop and channel in ("", heard.channel)]

    def stops(self, channel: str = "") -> list[Heard]:
        """Return the messages that stop it."""
        return [heard for heard in self.heard if heard.is_stop and channel in ("", heard.channel)]

    def close(self) -> None:
        self._is_closing = True
        self._thread.join()
        self._bus.close()

    def _listen(self) -> None:
        while not self._is_closing:
            self._bus.handle(0.05)

    def _hear(self, channel: str, data: bytes) -> None:
        utime, seq, twist = decode(Twist, data)
        with self._more:
            self.heard.append(Heard(time.monotonic(), channel, utime, seq, twist.v_mps))
            self._more.notify_all()


def go(seq: int = 0, v_mps: float = GO_MPS) -> bytes:
    """Return an encoded command, stamped now."""
    return encode(Twist(v_mps, 0.0), time.time_ns() // 1000, seq)


def motor(name: str, max_age_s: float = 0.2) -> MotorChannel:
    """Return a channel of twists."""
    return MotorChannel(name, encode(Twist(0.0, 0.0), 0, 0), 8, 16, max_age_s)


def is_gone(pid: int) -> bool:
    """Whether a process has ended; until it is reaped it may still be listed."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True
    return stat.rpartition(")")[2].split()[0] in ("Z", "X")


def wait_until(is_true: Callable[[], object]) -> None:
    """Wait for a condition that nothing announces."""
    until_s = time.monotonic() + LIMIT_S
    while not is_true():
        assert time.monotonic() < until_s
        time.sleep(0.005)
