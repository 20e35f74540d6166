"""An input that a recorded stage reads in the replay and did not read in the run."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from graphnav.live.firing import Used
from graphnav.live.live_unit import MAX_GATHERED
from graphnav.messages import Message
from graphnav.stage import Latest, Port, Since

_MAX_STAMPS = 256


class NewPort:
    """Holds what arrived on such an input until its stage fires, as it did in the run.

    A plain one gives the message of the firing's stamp, `Latest` the newest one, `Since` those after the last firing.
    """

    def __init__(self, port: Port) -> None:
        self.port = port
        self._waiting: list[tuple[Used, Message, float]] = []

    def deliver(self, utime: int, message: Message, birth_s: float, _now_s: float, number: int) -> None:
        """Take a message; ``number``: which one of its channel it is, ``birth_s``: what its age is counted from."""
        if self.port.latest:
            self._waiting.clear()
        self._waiting.append((Used(self.port.name, number, utime), message, birth_s))
        del self._waiting[: -(MAX_GATHERED if self.port.since else _MAX_STAMPS)]

    def take(self, stamp: int | None, now_s: float) -> tuple[Any, Sequence[Used]]:
        """Return what the stage steps with, and which messages that is; ``stamp``: None for the newest message.

        What a plain input lacks is None.
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
