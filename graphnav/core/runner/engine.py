"""The engine of every run and replay: it owns stages, connects, steps and publishes; a schedule decides what fires."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from enum import StrEnum
from functools import partial
from typing import Any, Generic, Protocol

from graphnav.core.bus import Bus
from graphnav.core.codec import DecodeError, EncodeError, codec_of, decode, encode
from graphnav.core.errors import StageError
from graphnav.core.graph import Channel, Graph, Node
from graphnav.core.messages import Message, Twist
from graphnav.core.runner.remote_unit import Encoded, RemoteStage, RemoteUnit
from graphnav.core.runner.stage_calls import StageCalls
from graphnav.core.runner.unit import I, LocalUnit, Publish, Unit
from graphnav.core.stage import Port, Stage

Readers = dict[str, list[tuple[Unit[I], Port]]]
Arrived = Callable[[I, Port, int, int, Any], None]
Fire = Callable[[Unit[Any], int, dict[str, Any], float], str | None]
Encode = Callable[[Channel, int, int, Message], bytes]
Decode = Callable[[Channel, bytes], tuple[int, int, Message]]
Published = Callable[[Channel, int, int, Message | Encoded, bytes], None]


class Outcome(StrEnum):
    """The outcome of a run."""

    GOAL = "goal"
    CONTACT = "contact"
    TIMEOUT = "timeout"
    END = "end"
    STOPPED = "stopped"
    FAILED = "failed"


class Sink(Protocol):
    """A receiver of every message of a run: the log, the tap."""

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Write one message as it was published."""


class Spans:
    """Wraps each part of the engine's work where a run is wired; this one leaves all as it is.

    The spans are nested: a tick fires stages, a firing steps and publishes, publishing encodes, gives to the sinks and
    sends; the bus delivers, which decodes.
    """

    def tick(self, tick: Callable[[], str | None]) -> Callable[[], str | None]:
        """Wrap a tick of lockstep."""
        return tick

    def fire(self, fire: Fire) -> Fire:
        """Wrap a firing: unit, stamp, inputs and age."""
        return fire

    def step(self, _stage: str, step: Callable[..., Any]) -> Callable[..., Any]:
        """Wrap the step of a stage, which gets its inputs by name."""
        return step

    def publish(self, publish: Publish) -> Publish:
        """Wrap the publication of a message: channel, stamp, message."""
        return publish

    def encode(self, encode: Encode) -> Encode:
        """Wrap what encodes: channel, stamp, number, message."""
        return encode

    def decode(self, decode: Decode) -> Decode:
        """Wrap what decodes: channel, bytes."""
        return decode

    def sinks(self, sinks: Sequence[Sink]) -> Sequence[Sink]:
        """Wrap the receivers of messages: the log, then the tap if there is one."""
        return sinks

    def bus(self, bus: Bus) -> Bus:
        """Wrap the bus."""
        return bus


class Engine(Generic[I]):
    """Owns stages, the bus between them, and the receivers of their messages; a schedule tells it what to fire.

    ``stages``: by name; a `RemoteStage` stands for one of another process.
    ``make_inbox``: returns what holds the messages that arrived for a stage. ``arrived``: puts one there: inbox, port,
    stamp, number, message. ``is_wired``: whether stages hear what others publish; else only what the schedule delivers.
    ``played``: channels on which nothing is published, because a log gives their messages. ``commands``: channels whose
    last message `give_stops` takes back. ``published``: gets every message before anything else does: channel, stamp,
    number, message (`Encoded` from another process), bytes. ``begin_us``: the clock at the start, 0 in simulated time.
    ``spans`` measures the work, ``calls`` notes the calls into stages.
    """

    def __init__(
        self,
        nodes: Iterable[Node],
        stages: Mapping[str, Stage | RemoteStage],
        sinks: Sequence[Sink],
        make_inbox: Callable[[Node], I],
        arrived: Arrived[I],
        *,
        is_wired: bool = True,
        played: Collection[str] = (),
        commands: Iterable[Channel] = (),
        published: Published | None = None,
        begin_us: int = 0,
        spans: Spans | None = None,
        calls: StageCalls | None = None,
    ) -> None:
        spans, calls = spans or Spans(), calls or StageCalls()
        self._make_inbox, self._is_wired = make_inbox, is_wired
        self.ticks = 0
        """Number of ticks, or of firings if there are no ticks."""
        self.utime = self.begin_us = begin_us
        """The clock, microseconds."""
        self.is_ready = False
        """Whether every stage was reset."""
        self.sinks = spans.sinks(sinks)
        self.fire: Fire = spans.fire(self._fire)
        """Steps a stage with the inputs of a stamp, by port, and their age, s; delivers what it publishes; returns the
        outcome if a source ended the run, and raises StageError."""
        self._bus = spans.bus(Bus())
        self._arrived, self._published = arrived, published
        self._encode, self._decode = spans.encode(_encoded), spans.decode(decoded)
        publish = spans.publish(self._publish)
        self.units: dict[str, Unit[I]] = {
            node.name: LocalUnit(node, stage, make_inbox(node), publish, calls, spans.step, begin_us)
            if isinstance(stage := stages[node.name], Stage)
            else RemoteUnit(node, stage, make_inbox(node), self._deliver_encoded, self._record, calls, begin_us)
            for node in nodes
        }
        """The stages, by name."""
        self._played = frozenset(played)
        self._commands = {channel.name: channel for channel in commands}
        self._commanded_us: dict[str, int] = {}
        """The stamp of the last message on each of these channels."""
        self._stamp, self._numbers = begin_us, dict[str, int]()
        self._plain, self._subscribed = set[str](), set[str]()
        self.readers: Readers[I] = {}
        """The stages that read a channel, and their ports, by the channel's name."""
        self._local_readers, self._remote_readers = Readers[I](), Readers[I]()
        self._connect()

    def _connect(self) -> None:
        """Find the readers of every channel, unless nothing is wired; subscribe once where they are in this process."""
        channels: dict[str, Channel] = {}
        self.readers, self._local_readers, self._remote_readers = {}, {}, {}
        for unit in self.units.values() if self._is_wired else ():
            for link in unit.node.inputs:
                if link.channel is not None:
                    channels[link.channel.name] = link.channel
                    apart = self._remote_readers if isinstance(unit, RemoteUnit) else self._local_readers
                    for readers in (self.readers, apart):
                        readers.setdefault(link.channel.name, []).append((unit, link.port))
                    if link.port.is_plain:
                        self._plain.add(link.channel.name)
        for name in self._local_readers:
            if name not in self._subscribed:
                self._bus.subscribe(name, partial(self._receive, channels[name]))
        self._subscribed.update(self._local_readers)

    def remote_units(self, nodes: Iterable[Node]) -> list[RemoteUnit[I]]:
        """Return those of some stages that live in other processes."""
        return [unit for node in nodes if isinstance(unit := self.units[node.name], RemoteUnit)]

    def change(self, graph: Graph, nodes: Iterable[Node], stages: Mapping[str, Stage]) -> list[StageError]:
        """Let other stages take the place of those of the same names, between two firings.

        ``graph``: with them. ``stages``: those of this process, which are reset; those of others are `prepared` there.
        What waits for a stage stays where it is read alike. Returns what stages of this process raised when they were
        closed.
        """
        at_s, failed = (self.utime - self.begin_us) / 1e6, []
        for node in nodes:
            unit, inbox = self.units[node.name], self._make_inbox(node)
            if isinstance(unit, LocalUnit):
                error = unit.change(node, stages[node.name], inbox, at_s)
                failed += [] if error is None else [error]
            elif isinstance(unit, RemoteUnit):
                unit.change(graph, node, inbox, self.utime)
        self._connect()
        return failed

    def begin_at(self, begin_us: int) -> None:
        """Let the clock start at another time."""
        self.utime = self.begin_us = begin_us
        for unit in self.units.values():
            unit.start_utime = begin_us

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from the run's ``seed``, and the clock to the start.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        self._numbers.clear()
        self._commanded_us.clear()
        self.is_ready = False
        self.ticks, self.utime = 0, self.begin_us
        for name, unit in self.units.items():
            unit.reset(seed, seed_of(seed, name))
        self.is_ready = True

    def close(self) -> None:
        """Close every stage, even if another one fails to close, and the bus.

        Raises
        ------
        StageError
            The first failure, after every stage was closed.
        """
        failed = None
        at_s = (self.utime - self.begin_us) / 1e6
        for unit in self.units.values():
            try:
                unit.close(at_s)
            except StageError as error:  # the others must still be closed
                failed = failed or error
        self._bus.close()
        if failed:
            raise failed

    def number(self, channel: str) -> int:
        """Return the number of the next message of a channel, from 0."""
        number = self._numbers[channel] = self.next_number(channel)
        return number

    def next_number(self, channel: str) -> int:
        """Return the number that the next message of a channel will have."""
        return self._numbers.get(channel, -1) + 1

    def set_next_number(self, channel: str, number: int) -> None:
        """Let the next message of a channel have this number."""
        self._numbers[channel] = number - 1

    def play(self, channel: str, utime: int, data: bytes, sinks: Sequence[Sink]) -> None:
        """Give a message of another origin to ``sinks``, and to the stages of this process that read its channel."""
        for sink in sinks:
            sink.write(channel, utime, data)
        if channel in self._local_readers:
            self._bus.publish(channel, data)
            self._bus.drain()

    def give_stops(self, sinks: Sequence[Sink]) -> None:
        """Take back the last command on every channel that moves a world: ``sinks`` get a stop with its stamp.

        No stage gets it: the run has ended.

        Raises
        ------
        LogError
            A log cannot be written.
        """
        for name, utime in self._commanded_us.items():
            data = self._encode(self._commands[name], utime, self.number(name), Twist(v_mps=0.0, omega_radps=0.0))
            for sink in sinks:
                sink.write(name, utime, data)
        self._commanded_us.clear()

    def deliver(self, channel: str, utime: int, number: int, message: Message) -> None:
        """Give a message to every stage of this process that reads its channel."""
        for place, (unit, port) in enumerate(self._local_readers.get(channel, ())):
            # a stage that changes what it was given changes nothing for others
            self._arrived(unit.inbox, port, utime, number, message.twin() if place else message)

    def deliver_bytes(self, channel: str, utime: int, number: int, data: bytes) -> None:
        """Give a message to every stage of another process that reads its channel."""
        readers = self._remote_readers.get(channel)
        if not readers:
            return
        encoded = Encoded(data)
        for unit, port in readers:
            self._arrived(unit.inbox, port, utime, number, encoded)

    def _fire(self, unit: Unit[I], stamp: int, inputs: dict[str, Any], age_s: float) -> str | None:
        self._stamp = stamp
        outcome = unit.step(stamp, inputs, age_s)
        self._bus.drain()
        return outcome

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        name = channel.name
        if name in self._played:
            return
        self._check_stamp(name, self._stamp, utime)
        number = self._count(name, utime)
        if name not in self.readers and not self.sinks and self._published is None:
            return
        data = self._encode(channel, utime, number, message)
        if self._published is not None:
            self._published(channel, utime, number, message, data)
        self.deliver_bytes(name, utime, number, data)
        for sink in self.sinks:
            sink.write(name, utime, data)
        if name in self._local_readers:
            self._bus.publish(name, data)

    def _check_stamp(self, channel: str, firing: int, utime: int) -> None:
        """Raise ValueError if a message has another stamp than its ``firing``, and a reader that joins by stamps."""
        if utime != firing and channel in self._plain:
            raise ValueError("it has a stamp of its own, but feeds a plain input: read it as Latest or Since")

    def _count(self, channel: str, utime: int) -> int:
        """Return the number of a message that is published."""
        if channel in self._commands:
            self._commanded_us[channel] = utime
        return self.number(channel)

    def _deliver_encoded(self, channel: Channel, firing: int, utime: int, data: bytes) -> None:
        """Give a message that a stage of another process published to its readers."""
        self._check_stamp(channel.name, firing, utime)
        if self._published is not None:
            self._published(channel, utime, self.next_number(channel.name), Encoded(data), data)
        if channel.name in self._remote_readers:
            number = codec_of(channel.message.lcm_class).peek(data, "seq") or 0
            self.deliver_bytes(channel.name, utime, number, data)
        if channel.name in self._local_readers:
            self._receive(channel, channel.name, data)

    def _record(self, channel: Channel, utime: int, data: bytes) -> None:
        """Give it to the sinks, in its turn."""
        self._count(channel.name, utime)
        for sink in self.sinks:
            sink.write(channel.name, utime, data)

    def _receive(self, channel: Channel, name: str, data: bytes) -> None:
        utime, number, message = self._decode(channel, data)
        self.deliver(name, utime, number, message)


def seed_of(run_seed: int, stage: str) -> int:
    """Return the seed of a stage, below 2**32, from the run's seed and the stage's name: no swap changes another's."""
    return int.from_bytes(hashlib.sha256(f"{run_seed}/{stage}".encode()).digest()[:4], "big")


def _encoded(_channel: Channel, utime: int, number: int, message: Message) -> bytes:
    try:
        return encode(message, utime, number)
    except EncodeError as error:
        raise ValueError(str(error)) from error


def decoded(channel: Channel, data: bytes) -> tuple[int, int, Message]:
    """Return stamp, number and message of a channel; raises DecodeError, which names the stage that published it."""
    try:
        return decode(channel.message, data)
    except DecodeError as error:
        raise DecodeError(f"stage '{channel.stage}': output '{channel.port}' is {error}") from error
