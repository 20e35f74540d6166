"""Messages of the firings of a recorded live run that wait for a stage: made again, or from the log."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from graphnav import Latest, Message, Since
from graphnav.core.graph import Node
from graphnav.core.runner import LiveInbox, Taken, Used
from graphnav.core.stage import Port
from graphnav.replay.log.firings import Firing

_MAX_STAMPS = 256


class Read(NamedTuple):
    """A message of a step, and its index on the channel in the log of the replay."""

    message: Message
    number: int


class RecordedInbox:
    """Holds the messages of a stage that recorded firings read, until they do.

    ``awaited``: how often firings read a published message, by stage, port and stamp. ``played``: returns a message of
    a played channel. ``new_ports``: the inputs that the stage did not read in the run.
    """

    dropped = 0

    def __init__(
        self,
        node: Node,
        awaited: Counter[tuple[str, str, int]],
        played: Callable[[str, Used], Read | None],
        new_ports: Sequence[Port],
    ) -> None:
        self._node, self._awaited, self._played = node, awaited, played
        self._new = {port.name: NewPort(port) for port in new_ports}
        self._published: dict[tuple[str, int], Read] = {}

    def adopt(self, before: RecordedInbox) -> None:
        """Take what waits for the stage before on inputs that read the same channel alike."""
        same = self._node.same_inputs(before._node)
        self._published = {key: read for key, read in before._published.items() if key[0] in same}
        self._new |= {port: new for port, new in before._new.items() if port in same}

    def put(self, port: Port, utime: int, number: int, message: Message, birth_s: float, _now_s: float) -> None:
        """Add a message; ``birth_s``: the time from which its age counts."""
        if (new := self._new.get(port.name)) is not None:
            new.put(utime, number, message, birth_s)
        elif self._awaited[self._node.name, port.name, utime]:
            self._published[port.name, utime] = Read(message, number)

    def take(self, firing: Firing, now_s: float) -> Taken | None:
        """Return what the stage steps with in a firing, None if a message of a plain input was not published again."""
        logged: dict[str, list[Used]] = defaultdict(list)
        for one in firing.used:
            logged[one.port].append(one)
        plain = [one.utime for i in self._node.inputs if i.port.is_plain for one in logged[i.port.name]]
        stamp = firing.utime if self._node.every_ms is None else next(iter(plain), None)
        inputs: dict[str, Any] = {}
        used: list[Used] = []
        is_complete = True
        for i in self._node.inputs:
            port = i.port.name
            if i.channel is None:
                if not i.port.is_plain:
                    inputs[port] = Latest(is_connected=False) if i.port.latest else Since()
                continue
            if (new := self._new.get(port)) is not None:
                value, found = new.take(stamp, now_s)
                is_complete &= value is not None or i.port.optional
            else:
                value, found = self._recorded(i.port, i.channel.name, logged[port])
                is_complete &= value is not None or not logged[port]
            inputs[port] = value
            used += found
        return Taken(inputs, firing.age_s, used) if is_complete else None

    def _recorded(self, port: Port, channel: str, logged: Sequence[Used]) -> tuple[Any, list[Used]]:
        """Return the recorded value of an input, and its messages."""
        read = [(self._read(channel, one), one) for one in logged]
        used = [one._replace(number=found.number if found else -1) for found, one in read if found or port.latest]
        if port.since:
            return Since(tuple((one.utime, found.message) for found, one in read if found)), used
        found, first = read[0] if read else (None, None)
        message = found.message if found else None
        if not port.latest:
            return message, used[:1]
        return (Latest(message, first.age_s, first.fault) if first else Latest()), used[:1]

    def _read(self, channel: str, used: Used) -> Read | None:
        if used.number < 0:
            return None
        key = self._node.name, used.port, used.utime
        if key not in self._awaited:
            return self._played(channel, used)
        self._awaited[key] -= 1
        at = used.port, used.utime
        return self._published.get(at) if self._awaited[key] else self._published.pop(at, None)


class NewPort:
    """Holds the messages of a new input until its stage fires at a recorded time.

    A plain input gives the message of the firing's timestamp, `Latest` the newest one, `Since` those after the last
    firing.
    """

    def __init__(self, port: Port) -> None:
        self.port = port
        self._waiting: list[tuple[Used, Message, float]] = []

    def put(self, utime: int, number: int, message: Message, birth_s: float) -> None:
        """Add a message; ``number``: its index on the channel, ``birth_s``: the time from which its age counts."""
        if self.port.latest:
            self._waiting.clear()
        self._waiting.append((Used(self.port.name, number, utime), message, birth_s))
        del self._waiting[: -(LiveInbox.MAX_GATHERED if self.port.since else _MAX_STAMPS)]

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
