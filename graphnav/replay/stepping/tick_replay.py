"""The schedule of a lockstep log: stages step by its ticks; messages of other stages are played from it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import NamedTuple

from graphnav import Graph, Recording, Stage
from graphnav.core.codec import decode
from graphnav.core.errors import StageError
from graphnav.core.runner import LockstepEngine, Sink
from graphnav.replay.log.changes import MadeChange
from graphnav.replay.log.contents import Logged
from graphnav.replay.log.schedule import Tick
from graphnav.replay.plan import Plan
from graphnav.replay.stepping.repeated_changes import RepeatedChanges
from graphnav.replay.stepping.reproduced_sources import Made, ReproducedSources


class Timetable(NamedTuple):
    """When the stages step: at ``ticks``, from ``start_us`` on.

    ``before``: messages from before the first tick, for stages that sample their channels. ``end_us``: the newest stamp
    of the log, up to which sources are stepped again; 0 if only a part of the log can be replayed. ``stops``: with
    which the run took back its last commands.
    """

    ticks: Sequence[Tick]
    before: Sequence[Logged]
    start_us: int
    end_us: int
    stops: Sequence[Logged] = ()


class Sinks(NamedTuple):
    """The receivers of messages: ``results`` take what is stepped, ``logs`` also what is played."""

    results: Sequence[Sink]
    logs: Sequence[Sink] = ()


class TickReplay:
    """Fires the stepping stages tick by tick of the log, in the firing order of the complete graph.

    ``again``: the sources that make again what the log leaves out. ``changes``: of stages while the run went on.
    """

    def __init__(
        self,
        plan: Plan,
        stages: Mapping[str, Stage],
        recording: Recording,
        timetable: Timetable,
        sinks: Sinks,
        again: ReproducedSources | None = None,
        changes: Sequence[MadeChange] = (),
    ) -> None:
        self._played = {channel.name for channel in plan.played}
        self.engine = LockstepEngine(
            plan.stepped_at_first.nodes,
            stages,
            (*sinks.results, *sinks.logs),
            played=self._played,
            commands=plan.graph.commands,
        )
        self._recording, self._timetable = recording, timetable
        self._results, self._player_sinks = sinks
        self._again = again
        self._messages = {channel.name: channel.message for channel in plan.graph.channels.values()}
        self._outside = dict.fromkeys(channel.stage for channel in plan.played if channel.ref in plan.graph.inputs)
        self._firing_order = self._order_of(plan.began)
        self._changes = RepeatedChanges(changes, self.engine, sinks.logs)

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``, and the sources that are stepped again from that of the run.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        if self._again is not None:
            self._again.reset()
        self.engine.reset(seed)

    def close(self) -> None:
        """Close the stages.

        Raises
        ------
        StageError
            The first failure, after every stage was closed.
        """
        try:
            if self._again is not None:
                self._again.engine.close()
        finally:
            self.engine.close()

    def replay(self) -> Iterator[int]:
        """Process the ticks; yield the timestamp of each one, microseconds.

        Raises
        ------
        StageError
            A stage raised, or returned an invalid value.
        DecodeError
            A message of the log is damaged.
        """
        try:
            yield from self._replay()
        except StageError:
            self._stop()
            raise
        self._stop()

    def _stop(self) -> None:
        """Take back the last commands as the run did; only logs get that."""
        for stop in self._timetable.stops:
            if stop.channel in self._played:
                data = self._recording.event(stop.channel, stop.place).data
                for sink in self._player_sinks:
                    sink.write(stop.channel, stop.utime, data)
        if self._timetable.stops:
            self.engine.give_stops(self._player_sinks)

    def _replay(self) -> Iterator[int]:
        self._catch_up()
        if self._timetable.ticks and self._timetable.start_us:
            self._change(self._timetable.start_us)
        for message in self._timetable.before:
            data = self._recording.event(message.channel, message.place).data
            self._prime(message.channel, message.utime, data)
        for tick in self._timetable.ticks:
            for stamp in self._due_before(tick.utime):
                self._tick(Tick(stamp))
            self._tick(tick)
            self.engine.ticks += 1
            yield tick.utime
        while self._again is not None and self._again.engine.utime < self._timetable.end_us:
            self._tick(Tick(self._again.next_due()))

    def _due_before(self, utime: int) -> Iterator[int]:
        """Yield the stamps before a tick at which a source is stepped again, each when the one before is done."""
        while self._again is not None and (stamp := self._again.next_due()) < utime:
            yield stamp

    def _order_of(self, graph: Graph) -> list[str]:
        return [*self._outside, *(node.name for node in (*graph.sources, *graph.order))]

    def _change(self, utime: int) -> None:
        """Let stages take over that did so before this tick of the run."""
        graph = self._changes.make(utime)
        if graph is not None:
            self._firing_order = self._order_of(graph)

    def _catch_up(self) -> None:
        """Step the sources that are stepped again up to the start; deliver their newest messages."""
        newest: dict[str, Made] = {}
        for stamp in self._due_before(self._timetable.start_us):
            for name in self._firing_order:
                for made in self._again.fire(name, stamp) if self._again is not None else ():
                    newest[made.channel.name] = made
        for name, made in newest.items():
            if name not in self._played:
                self._prime(name, made.utime, made.data)

    def _tick(self, tick: Tick) -> None:
        """Publish the messages of a tick and fire the stages whose plain inputs are then complete."""
        self._change(tick.utime)
        self.engine.utime = tick.utime
        for name in self._firing_order:
            made = self._again.fire(name, tick.utime) if self._again is not None else []
            for message in merged(tick.played.get(name, ()), made, self._played):
                if isinstance(message, Made):
                    self.engine.play(message.channel.name, message.utime, message.data, self.engine.sinks)
                else:
                    self._play(message)
            for one in made:
                if one.channel.name in self._played:
                    self._compare(one)
            if (unit := self.engine.units.get(name)) is not None:
                self.engine.fire_complete(unit, tick.utime)

    def _compare(self, made: Made) -> None:
        """Compare a message that is made again with the recorded one, which is played."""
        for sink in self._results:
            sink.write(made.channel.name, made.utime, made.data)

    def _prime(self, name: str, utime: int, data: bytes) -> None:
        """Deliver a message from before the first tick to stages that sample its channel; it fires no stage."""
        readers = self.engine.readers.get(name, ())
        sampling = [(unit, port) for unit, port in readers if port.latest]
        if sampling and not any(port.is_plain for _, port in readers):
            for sink in self._player_sinks:
                sink.write(name, utime, data)
        sent, _, value = decode(self._messages[name], data)
        for unit, port in sampling:
            unit.inbox.put(port, sent, 0, value)

    def _play(self, message: Logged) -> None:
        if message.channel in self.engine.readers or self._player_sinks:
            data = self._recording.event(message.channel, message.place).data
            self.engine.play(message.channel, message.utime, data, self._player_sinks)


def merged(recorded: Sequence[Logged], made: Sequence[Made], played: Collection[str]) -> Iterator[Logged | Made]:
    """Yield the messages of a source at a tick: the recorded ones, and those made again on channels not ``played``.

    Both keep their order; a message made again on a played channel tells where the recorded one belongs.
    """
    places = {(one.channel, one.utime, one.seq): place for place, one in enumerate(recorded)}
    n_done = 0
    for one in made:
        place = places.get((one.channel.name, one.utime, one.seq), -1)
        if one.channel.name not in played:
            yield one
        elif place >= n_done:
            yield from recorded[n_done : place + 1]
            n_done = place + 1
    yield from recorded[n_done:]
