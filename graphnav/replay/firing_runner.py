"""Repeats the firings of a live log: every step gets the messages that it got in the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graphnav.codec import EncodeError, decode, encode
from graphnav.graph import Channel
from graphnav.live.firing import Used
from graphnav.messages import Message
from graphnav.record import Recording
from graphnav.replay.firings import Firing, LoggedFirings
from graphnav.replay.plan import Plan
from graphnav.runner.lifecycle import close_stages, reset_stages
from graphnav.runner.unit import Unit
from graphnav.runner.wired_stages import Sink
from graphnav.stage import Latest, Since, Stage


class FiringRunner:
    """Owns the stages that step, and fires them in the order of the log.

    A message of a played channel is that of the log, one of a stage that steps is what this stage published now with
    the same stamp. A firing that lacks a message on a plain input, because its stage has not published it now, is left
    out. ``begin_us``, ``start_us``: the run's clock when it began, and from when on its firings are repeated.
    """

    def __init__(
        self,
        plan: Plan,
        stages: Mapping[str, Stage],
        recording: Recording,
        logged: LoggedFirings,
        sinks: Sequence[Sink],
        begin_us: int,
        start_us: int,
    ) -> None:
        self.ticks = 0
        """Firings."""
        self.utime = begin_us
        """The run's clock at the newest firing."""
        self.is_ready = False
        self._recording, self._logged, self._sinks = recording, logged, sinks
        self._begin_us, self._start_us = begin_us, start_us
        self._units = {node.name: Unit(node, stages[node.name], self._publish) for node in plan.stepped.nodes}
        self._played = {channel.name for channel in plan.played}
        self._seqs: dict[str, int] = {}
        self._awaited = logged.awaited.copy()
        self._published: dict[tuple[str, int], Message] = {}

    @property
    def units(self) -> Mapping[str, Unit]:
        """The stages at work, by name."""
        return self._units

    def reset(self, seed: int) -> None:
        """Make every stage's state anew from ``seed``.

        Raises
        ------
        StageError
            A stage cannot be made ready.
        """
        reset_stages(self._units, seed)
        self.is_ready = True

    def replay(self) -> Iterator[int]:
        """Repeat the firings; yield the run's clock at each one that is done, microseconds.

        Raises
        ------
        StageError
            A stage raised, or returned what it may not.
        DecodeError
            A message of the log is damaged.
        """
        for firing in self._logged.firings:
            if firing.at_us >= self._start_us:
                self.utime = firing.at_us
                self._fire(firing)
                self.ticks += 1
                yield firing.at_us

    def close(self) -> None:
        """Release what the stages hold.

        Raises
        ------
        StageError
            The first failure, once every stage was closed.
        """
        close_stages(self._units, (self.utime - self._begin_us) / 1e6)

    def _fire(self, firing: Firing) -> None:
        unit = self._units[firing.stage]
        inputs: dict[str, Any] = {}
        used: dict[str, list[Used]] = {}
        for one in firing.used:
            used.setdefault(one.port, []).append(one)
        is_complete = True
        for i in unit.node.inputs:
            name, found = i.port.name, used.get(i.port.name, [])
            if i.port.latest:
                inputs[name] = self._sampled(i.channel, found)
                continue
            messages = [(one.utime, self._message(i.channel, one)) for one in found if i.channel is not None]
            if i.port.since:
                inputs[name] = Since(tuple((utime, message) for utime, message in messages if message is not None))
            elif i.channel is not None:
                inputs[name] = messages[0][1] if messages else None
                is_complete &= inputs[name] is not None or not messages
        if is_complete:
            unit.step(firing.utime, inputs, firing.age_s)

    def _sampled(self, channel: Channel | None, used: Sequence[Used]) -> Latest[Any]:
        if channel is None:
            return Latest(is_connected=False)
        if not used:
            return Latest()
        return Latest(self._message(channel, used[0]), used[0].age_s, used[0].fault)

    def _message(self, channel: Channel | None, used: Used) -> Message | None:
        if channel is None or used.number < 0:
            return None
        if channel.name in self._played:
            logged = self._logged.played[channel.name, used.number, used.utime]
            return decode(channel.message, self._recording.event(channel.name, logged.place).data)[2]
        key = channel.name, used.utime
        self._awaited[key] -= 1
        return self._published.get(key) if self._awaited[key] else self._published.pop(key, None)

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        if channel.name in self._played:
            return
        seq = self._seqs[channel.name] = self._seqs.get(channel.name, -1) + 1
        try:
            data = encode(message, utime, seq)
        except EncodeError as error:
            raise ValueError(str(error)) from error
        for sink in self._sinks:
            sink.write(channel.name, utime, data)
        if self._awaited[channel.name, utime]:
            self._published[channel.name, utime] = decode(channel.message, data)[2]
