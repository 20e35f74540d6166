"""Repeat the firings of a live log: every step gets the same messages as in the run."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from graphnav.codec import decode
from graphnav.graph import Channel
from graphnav.live.firing import Used
from graphnav.live.live_unit import LiveUnit
from graphnav.messages import Message
from graphnav.record import Recording
from graphnav.replay.log.contents import Logged
from graphnav.replay.log.firings import Firing, LoggedFirings
from graphnav.replay.plan import Plan
from graphnav.replay.stepping.added_stages import AddedStages, Due
from graphnav.replay.stepping.firing_log import FiringLog
from graphnav.replay.stepping.new_port import NewPort
from graphnav.runner.owned_stages import OwnedStages, Sink
from graphnav.runner.unit import Unit
from graphnav.stage import Latest, Port, Since, Stage

Deliver = Callable[[int, Message, float, float, int], None]


class _Read(NamedTuple):
    """A message of a step, and its index on the channel in the log of the replay."""

    message: Message
    number: int


class FiringRunner(OwnedStages[Unit]):
    """Owns the stepping stages, and fires them in log order.

    Messages of played channels come from the log, those of stepping stages are the newly published ones of the same
    timestamp. A firing is skipped if a message of a plain input was not published again. Stages that the run did not
    have fire by the rule of `AddedStages`; inputs that a stage did not read in the run are `NewPort`s. ``begin_us``,
    ``start_us``: the run's clock at its start, and the time from which stages fire. ``log`` receives everything that is
    needed to replay this replay.
    """

    def __init__(
        self,
        plan: Plan,
        stages: Mapping[str, Stage],
        recording: Recording,
        logged: LoggedFirings,
        sinks: Sequence[Sink],
        log: FiringLog | None,
        begin_us: int,
        start_us: int,
    ) -> None:
        super().__init__(sinks, begin_us)
        self._recording, self._logged, self._log = recording, logged, log
        self._start_us = start_us
        self._messages = {channel.name: channel.message for channel in plan.graph.channels.values()}
        self._played = {channel.name for channel in plan.played}
        self._awaited = logged.awaited.copy()
        self._published: dict[tuple[str, int], _Read] = {}
        self._own_us = begin_us
        self._birth_s = 0.0
        self._readers: dict[str, list[tuple[Port, Deliver]]] = defaultdict(list)
        self._new_ports: dict[str, dict[str, NewPort]] = defaultdict(dict)
        added: list[LiveUnit] = []
        for node in plan.stepped.order:
            unit: Unit
            if node.name in logged.added:
                unit = LiveUnit(node, stages[node.name], self._publish, plan.graph.queues, lambda *_: "")
                unit.before_step = self._log_added
                added.append(unit)
                for i in node.inputs:
                    if i.channel is not None:
                        self._readers[i.channel.name].append((i.port, partial(unit.deliver, i.port.name)))
            else:
                unit = Unit(node, stages[node.name], self._publish)
                for i in node.inputs:
                    if i.channel is not None and (node.name, i.port.name) in logged.new_ports:
                        new = self._new_ports[node.name][i.port.name] = NewPort(i.port)
                        self._readers[i.channel.name].append((i.port, new.deliver))
            unit.start_utime = begin_us
            self._units[node.name] = unit
        self._added_names = frozenset(unit.node.name for unit in added)
        self._added = AddedStages(added, (start_us - begin_us) / 1e6)

    def replay(self) -> Iterator[int]:
        """Repeat the firings; yield the run's clock after each one, microseconds.

        Raises
        ------
        StageError
            A stage raised, or returned an invalid value.
        DecodeError
            A message of the log is damaged.
        """
        for one in self._events():
            if one.at_us >= self._start_us:
                yield from self._fire_added(one.at_us)
            self.utime = one.at_us
            if isinstance(one, Logged):
                self._hear(one)
            elif one.stage not in self._units:
                self._copy(one)
            elif one.at_us >= self._start_us and one.stage not in self._added_names:
                self.ticks += self._fire(one)
                yield one.at_us
            if one.at_us >= self._start_us:
                yield from self._fire_added(one.at_us)

    def _events(self) -> Iterator[Logged | Firing]:
        """Yield the firings, each one preceded by the messages up to then that are read or copied."""
        is_wanted = self._readers.__contains__ if self._log is None else lambda _: True
        messages = [one for one in self._logged.messages if is_wanted(one.channel)]
        place = 0
        for firing in self._logged.firings:
            while place < len(messages) and messages[place].at_us <= firing.at_us:
                yield messages[place]
                place += 1
            yield firing
        if not self._logged.is_cut:
            yield from messages[place:]

    def _fire_added(self, to_us: int) -> Iterator[int]:
        while self._added_names and (due := self._added.next_due(self._run_s(to_us))) is not None:
            self.utime = self._begin_us + round(due.at_s * 1e6)
            due.fire(self._stamp_of(due))
            self.ticks += 1
            yield self.utime

    def _stamp_of(self, due: Due) -> int:
        if due.utime is not None:
            return due.utime
        self._own_us = max(self._own_us + 1, self.utime)
        return self._own_us

    def _run_s(self, at_us: int) -> float:
        return (at_us - self._begin_us) / 1e6

    def _hear(self, logged: Logged) -> None:
        """Process a message of the log."""
        data = self._recording.event(logged.channel, logged.place).data
        number = logged.place if self._log is None else self._log.copy(logged, data)
        if logged.channel in self._readers:
            message = decode(self._messages[logged.channel], data)[2]
            self._deliver(logged.channel, logged.utime, message, self._run_s(logged.at_us), number)

    def _deliver(self, channel: str, utime: int, message: Message, birth_s: float, number: int) -> None:
        """Deliver a message to added stages and inputs; before the start only to those that sample it."""
        for port, deliver in self._readers[channel]:
            if port.latest or self.utime >= self._start_us:
                deliver(utime, message, birth_s, self._run_s(self.utime), number)

    def _fire(self, firing: Firing) -> bool:
        """Repeat a firing; return whether the stage stepped, False if a message of a plain input was not published."""
        unit = self._units[firing.stage]
        now_s = self._run_s(firing.at_us)
        inputs: dict[str, Any] = {}
        logged: dict[str, list[Used]] = defaultdict(list)
        used: list[Used] = []
        for one in firing.used:
            logged[one.port].append(one)
        plain = [one.utime for i in unit.node.inputs if i.port.is_plain for one in logged[i.port.name]]
        stamp = firing.utime if unit.node.every_ms is None else next(iter(plain), None)
        is_complete = True
        for i in unit.node.inputs:
            if i.channel is None:
                if not i.port.is_plain:
                    inputs[i.port.name] = Latest(is_connected=False) if i.port.latest else Since()
                continue
            if (new := self._new_ports[firing.stage].get(i.port.name)) is not None:
                value, found = new.take(stamp, now_s)
                is_complete &= value is not None or i.port.optional
            else:
                value, found = self._logged_value(i.port, i.channel, logged[i.port.name])
                is_complete &= value is not None or not logged[i.port.name]
            inputs[i.port.name] = value
            used += found
        if not is_complete:
            return False
        is_decision = unit.node.every_ms is not None or not math.isfinite(firing.age_s)
        self._birth_s = now_s if is_decision else now_s - firing.age_s
        try:
            unit.step(firing.utime, inputs, firing.age_s)
        finally:
            if self._log is not None:
                self._log.fire(firing.stage, firing.at_us, firing.utime, firing.age_s, used)
        return True

    def _logged_value(self, port: Port, channel: Channel, logged: Sequence[Used]) -> tuple[Any, list[Used]]:
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

    def _read(self, channel: Channel, used: Used) -> _Read | None:
        if used.number < 0:
            return None
        if channel.name in self._played:
            logged = self._logged.played[channel.name, used.number, used.utime]
            message = decode(channel.message, self._recording.event(channel.name, logged.place).data)[2]
            return _Read(message, self._log.number_of(channel.name, logged.place) if self._log else used.number)
        key = channel.name, used.utime
        self._awaited[key] -= 1
        return self._published.get(key) if self._awaited[key] else self._published.pop(key, None)

    def _copy(self, firing: Firing) -> None:
        """Write the firing of a stage that does not step, so that a replay of this replay can step it."""
        if self._log is None:
            return
        channels = self._logged.channels.get(firing.stage, {})
        used = [one._replace(number=self._log.number_of(channels.get(one.port, ""), one.number)) for one in firing.used]
        self._log.fire(firing.stage, firing.at_us, firing.utime, firing.age_s, used)

    def _log_added(self, unit: LiveUnit, utime: int, age_s: float, used: Sequence[Used]) -> None:
        self._birth_s = unit.birth_s
        if self._log is not None:
            self._log.fire(unit.node.name, self.utime, utime, age_s, used)

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        if channel.name in self._played:
            return
        seq = self._next_seq(channel)
        data = self._give(channel, utime, seq, message)
        if self._log is not None:
            self._log.publish(channel.name, self.utime, data)
        is_awaited = bool(self._awaited[channel.name, utime])
        if not is_awaited and channel.name not in self._readers:
            return
        copy = decode(channel.message, data)[2]
        if is_awaited:
            self._published[channel.name, utime] = _Read(copy, seq)
        self._deliver(channel.name, utime, copy, self._birth_s, seq)
