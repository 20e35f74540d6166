"""The commands on a robot's motor channel, heard by a plain python-lcm program."""

from __future__ import annotations

import threading
import time
from types import TracebackType
from typing import NamedTuple, Self

import graphnav_lcm
import lcm

BASE = "BASE_CMD"


class Heard(NamedTuple):
    """A command and when it arrived, monotonic seconds."""

    at_s: float
    v_mps: float
    omega_radps: float
    utime: int
    """Its stamp."""

    @property
    def is_stop(self) -> bool:
        """Whether it tells the robot to stand."""
        return self.v_mps == 0.0 and self.omega_radps == 0.0


class CommandListener:
    """Keeps every command that is sent to the robot while it is entered."""

    def __init__(self, url: str) -> None:
        self.heard: list[Heard] = []
        self._ending = threading.Event()
        self._lcm = lcm.LCM(url)
        self._lcm.subscribe(BASE, self._hear).set_queue_capacity(0)
        self._thread = threading.Thread(target=self._listen, daemon=True)

    def first_stop(self, after_s: float) -> Heard | None:
        """Return the first stop that arrived after a time, None if none has."""
        return next((one for one in self.since(after_s) if one.is_stop), None)

    def lasting_stop(self, begin_s: float, end_s: float) -> Heard | None:
        """Return the first stop between two times after which nothing else arrived, None if the last one is none."""
        lasting = None
        for one in self.since(begin_s):
            if one.at_s > end_s:
                break
            lasting = (lasting or one) if one.is_stop else None
        return lasting

    def since(self, after_s: float) -> list[Heard]:
        """Return what arrived after a time, oldest first."""
        newest_first = []
        for one in reversed(self.heard):
            if one.at_s <= after_s:
                break
            newest_first.append(one)
        return newest_first[::-1]

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ending.set()
        self._thread.join()

    def _hear(self, _channel: str, data: bytes) -> None:
        now_s = time.monotonic()
        twist = graphnav_lcm.twist_t.decode(data)
        self.heard.append(Heard(now_s, twist.v_mps, twist.omega_radps, twist.utime))

    def _listen(self) -> None:
        while not self._ending.is_set():
            self._lcm.handle_timeout(100)
