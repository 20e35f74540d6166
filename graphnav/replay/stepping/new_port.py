"""An input of a recorded stage that is new in the replay."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from graphnav.live.firing import Used
from graphnav.live.live_unit import MAX_GATHERED
from graphnav.messages import Message
from graphnav.stage import Latest, Port, Since

_MAX_STAMPS = 256


class NewPort:
    """Holds the messages of a new input until its stage fires at a recorded time.

    A plain input gives the message of the firing's timestamp, `Latest` the newest one, `Since` those after the last
    firing.
    """

    def __init__(self, port: Port) -> None:
        self.port = port
        self._waiting: list[tuple[Used, Message, float]] = []

    def deliver(self, utime: int, message: Message, birth_s: float, _now_s: float, number: int) -> None:
        """Add a message; ``number``: its index on the channel, ``birth_s``: the time from which its age counts."""
        if self.port.latest:
            self._waiting.clear()
        self._waiting.append((Used(self.port.name, number, utime), message, birth_s))
        del self._waiting[: -(MAX_GATHERED if self.port.since else _MAX_STAMPS)]

    def take(self, stamp: int | None, now_s: float) -> tuple[Any, Sequence[Used]]:
        """Return the value for the step, and its messages; ``stamp``: None for the newest message.

        A missing message of a plain input is None.
        """
        if self.port.latest:
            return self._sample(now_s)
        if self.port.since:
            taken, self._waiting = self._waiting, []
            return Since(tuple((used.utime, message) for used, message, _ in taken)), [used for used, *_ in taken]
        if stamp is None and self._waiting:
            stamp = self._waiting[-1][0].utime
        self._waiting = [one for one in self._waiting if stamp is not None and one[0].utime >= stamp]
        found = [(message, [used]) for used, message, _ in self._waiting if used.utime == stamp]
        return found[-1] if found else (None, [])

    def _sample(self, now_s: float) -> tuple[Latest[Any], Sequence[Used]]:
        if not self._waiting:
            empty: Latest[Any] = Latest()
            return empty, [Used(self.port.name, -1, 0, empty.age_s)]
        used, message, birth_s = self._waiting[-1]
        sampled = Latest(message, now_s - birth_s)
        return sampled, [used._replace(age_s=sampled.age_s)]
