"""Run a graph live: stages fire on the arrival of inputs, sources and timers on the wall clock."""

from __future__ import annotations

import math
import threading
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from graphnav.bus import Bus
from graphnav.codec import DecodeError, EncodeError, decode, encode
from graphnav.graph import Channel, Graph
from graphnav.live.clock import LiveClock
from graphnav.live.firing import FIRED, Used, encoded_firing
from graphnav.live.inputs.intake import Intake, Received
from graphnav.live.live_unit import LiveUnit
from graphnav.live.outlet import Outlet
from graphnav.live.timer import Timer, every
from graphnav.messages import GuardState, Message
from graphnav.runner.lifecycle import close_stages, reset_stages
from graphnav.runner.lockstep import Outcome
from graphnav.runner.owned_stages import Sink
from graphnav.stage import Stage

_MAX_UNLOGGED = 32
"""Maximum number of firings pending for the log if the run is never idle."""
_MAX_WAIT_S = 0.05
"""Interval of the checks whether the run should stop while no input arrives."""


class LiveRunner:
    """Owns the stages of a graph in a live run; one thread fires them all.

    At every turn one stage fires: a timer (``every_ms``) that is due, else a stage whose plain inputs are complete,
    the one nearest to the end of the graph first, else a source that is due. The kinds take turns, so that a timer or a
    source that takes longer than its period does not starve other stages. Messages that a slow stage misses are
    overtaken, not queued. ``step_began``: the running stage and the start of its step, for other threads; None between
    two steps.
    """

    def __init__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage],
        clock: LiveClock,
        intakes: Sequence[Intake],
        wake: threading.Event,
    ) -> None:
        self.graph = graph
        self.clock = clock
        self.is_ready = False
        self.firings = 0
        self.step_began: tuple[str, float] | None = None
        self.sinks: list[Sink] = []
        self._firing_log: Sink | None = None
        self._unlogged: list[tuple[int, str, int, float, Sequence[Used]]] = []
        self.outlets: dict[str, Outlet] = {}
        """By the reference of the channel that is sent."""
        self.guard_states: dict[str, GuardState] = {}
        """The newest state of each guard, by its stage."""
        self.intakes = {intake.source.channel.ref: intake for intake in intakes}
        self._wake = wake
        self._bus = Bus("memq://")
        self._seqs: dict[str, int] = defaultdict(int)
        self._numbers: dict[str, int] = defaultdict(int)
        self._newest_stamp = self._stamp = clock.start_utime
        self._units = {
            node.name: LiveUnit(node, stages[node.name], self._publish, graph.queues, self._fault_of)
            for node in graph.nodes
        }
        self._order = [self._units[node.name] for node in reversed(graph.order)]
        self._clocked: list[tuple[Timer, LiveUnit]] = []
        self._sources: list[tuple[Timer, LiveUnit]] = []
        self._source_was_last = self._timer_was_last = False
        self._plain = {i.channel.name for n in graph.nodes for i in n.inputs if i.channel and i.port.is_plain}
        self._readers: dict[str, list[tuple[LiveUnit, str]]] = defaultdict(list)
        for unit in self._units.values():
            for i in unit.node.inputs:
                if i.channel is not None:
                    self._readers[i.channel.name].append((unit, i.port.name))
        self._firing = next(iter(self._units.values()))
        self._subscribe()

    @property
    def units(self) -> Mapping[str, LiveUnit]:
        """The units of the stages, by name."""
        return self._units

    @property
    def skipped(self) -> int:
        """Firings of sources skipped because they were late by more than a period."""
        return sum(timer.skipped for timer, _ in self._sources)

    def overtaken(self) -> Counter[str]:
        """Return the number of overtaken messages by edge, ``stage.port``, without zeros."""
        counts = (
            (f"{name}.{port}", n) for name, unit in self._units.items() for port, n in unit.join.overtaken.items()
        )
        return Counter({edge: count for edge, count in counts if count})

    def log_to(self, sinks: Sequence[Sink], firings: Sink | None) -> None:
        """Write every message to the ``sinks``, and the inputs of every step to ``firings``, for replays."""
        self.sinks = list(sinks)
        self._firing_log = firings
        for unit in self._units.values():
            unit.before_step = None if firings is None else self._note_firing

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        reset_stages(self._units, seed)
        now_s = self.clock.now_s()
        for unit in self._units.values():
            unit.start_utime = self.clock.start_utime
        self._clocked = [
            (Timer(every(unit.node.every_ms / 1e3), now_s), unit) for unit in self._units.values() if unit.node.every_ms
        ]
        self._sources = [
            (Timer(_after_s(self._units[node.name]), now_s), self._units[node.name]) for node in self.graph.sources
        ]
        self.is_ready = True

    def is_needed(self, ref: str) -> bool:
        """Whether a stage cannot fire without this input, by reference."""
        return any(unit.needs(port) for unit, port in self._readers[self.intakes[ref].source.channel.name])

    def behind_s(self, now_s: float) -> float:
        """Return the lateness of the latest source or timer in seconds."""
        return max([0.0, *(now_s - timer.due_s for timer, _ in (*self._clocked, *self._sources))])

    def run(self, until_s: float | None, keep_going: Callable[[], bool], is_over: Callable[[], bool]) -> str:
        """Take turns until a source ends the run, ``until_s`` seconds have passed, or ``keep_going`` returns False.

        ``is_over`` returns whether no more input can arrive; it is called when idle.

        Raises
        ------
        StageError
            A stage raised, or returned something invalid.
        """
        end_s = math.inf if until_s is None else self.clock.now_s() + until_s
        fired = False
        while True:
            if self.clock.now_s() >= end_s:
                return Outcome.TIMEOUT
            if not keep_going():
                return Outcome.STOPPED
            if self._wake.is_set() or not fired:
                self._wake.clear()
                self._take_inputs()
            outcome, fired = self._turn()
            if outcome is not None:
                self._finish()
                return outcome
            if not fired and is_over():
                return Outcome.END
            if not fired:
                self._log_firings()
                self._wake.wait(self._wait_s(end_s))

    def close(self) -> None:
        """Close every stage, even if another one fails to close.

        Raises
        ------
        StageError
            The first failure, after every stage was closed.
        """
        self._log_firings()
        self._bus.close()
        close_stages(self._units, self.clock.run_s())

    def _turn(self) -> tuple[str | None, bool]:
        """Fire one stage; return the outcome if a source ended the run, and whether a stage fired."""
        now_s = self.clock.now_s()
        was_timer, self._timer_was_last = self._timer_was_last, False
        if was_timer:
            outcome, fired = self._turn_untimed(now_s)
            if fired:
                return outcome, True
        due = [pair for pair in self._clocked if pair[0].is_due(now_s)]
        if not due:
            return self._turn_untimed(now_s)
        timer, unit = min(due, key=lambda pair: pair[0].due_s)
        timer.advance(now_s)
        self._timer_was_last = True
        return self._fire(unit, self._own_stamp(now_s), partial(unit.fire_timer, now_s=now_s)), True

    def _turn_untimed(self, now_s: float) -> tuple[str | None, bool]:
        """Fire a stage whose inputs are complete or a source that is due; the same result as `_turn`."""
        due = next(((timer, unit) for timer, unit in self._sources if timer.is_due(now_s)), None)
        if due is None or self._source_was_last:
            for unit in self._order:
                if (matched := unit.ready(now_s)) is not None:
                    self._source_was_last = False
                    utime = self._own_stamp(now_s) if unit.is_clocked else matched.utime
                    outcome = self._fire(unit, utime, partial(unit.fire_set, matched, now_s=now_s))
                    unit.judge_deadline(matched.ready_s, self.clock.now_s())
                    return outcome, True
        if due is None:
            return None, False
        timer, unit = due
        utime = self.clock.utime_at(timer.due_s)
        timer.advance(now_s)
        self._source_was_last = True
        return self._fire(unit, utime, partial(unit.fire_source, now_s=now_s)), True

    def _finish(self) -> None:
        """Step with the messages that the source published when it ended the run."""
        for unit in reversed(self._order):
            if (matched := unit.ready(math.inf)) is not None:
                now_s = self.clock.now_s()
                utime = self._own_stamp(now_s) if unit.is_clocked else matched.utime
                self._fire(unit, utime, partial(unit.fire_set, matched, now_s=now_s))

    def _fire(self, unit: LiveUnit, utime: int, fire: Callable[[int], str | None]) -> str | None:
        self._firing, self._stamp = unit, utime
        self.step_began = unit.node.name, self.clock.now_s()
        outcome = fire(utime)
        self.step_began = None
        self._bus.drain()
        self.firings += 1
        return outcome

    def _wait_s(self, end_s: float) -> float:
        """Return the time until the next event other than the arrival of an input."""
        now_s = self.clock.now_s()
        due_s = min((timer.due_s for timer, _ in (*self._clocked, *self._sources)), default=math.inf)
        waking_s = min((unit.wakes_at_s() for unit in self._order), default=math.inf)
        return max(0.0, min(due_s, waking_s, end_s, now_s + _MAX_WAIT_S) - now_s)

    def _take_inputs(self) -> None:
        for intake in self.intakes.values():
            before = intake.overtaken
            for received in intake.take():
                self._deliver_input(intake, received)
            if intake.overtaken > before:
                for unit, port in self._readers[intake.source.channel.name]:
                    if unit.is_plain(port):
                        unit.join.overtaken[port] += intake.overtaken - before

    def _deliver_input(self, intake: Intake, received: Received) -> None:
        name = intake.source.channel.name
        if received.is_restart:
            self._restart(name)
        now_s = self.clock.now_s()
        number = self._numbers[name]
        self._numbers[name] = number + 1
        for unit, port in self._readers[name]:
            unit.deliver(port, received.utime, received.message.twin(), received.birth_s, now_s, number)
        if self.sinks:
            data = received.raw or encode(received.message, received.utime, self.next_seq(name))
            self.record(name, data)

    def _restart(self, name: str) -> None:
        """Drop what was made from an input that restarts; guards fire at once without it, which is a stop."""
        restarted: dict[str, LiveUnit] = {}
        pending = [name]
        while pending:
            for unit, port in self._readers[pending.pop()]:
                if unit.needs(port) and unit.node.name not in restarted:
                    restarted[unit.node.name] = unit
                    pending += [one.name for one in self.graph.channels.values() if one.stage == unit.node.name]
        for unit in restarted.values():
            unit.restart()
        for _, unit in self._clocked:
            if unit.node.name in restarted:
                now_s = self.clock.now_s()
                self._fire(unit, self._own_stamp(now_s), partial(unit.fire_timer, now_s=now_s))

    def withhold_commands(self, *, is_withheld: bool) -> None:
        """Give guards no command from now on, or again: one that is not sent must not count as driven."""
        for unit in self._units.values():
            if unit.node.stage_class.is_guard:
                unit.withhold(is_withheld=is_withheld)

    def record(self, name: str, data: bytes) -> None:
        """Write a message to the log and the tap, stamped now: senders' clocks may differ."""
        utime = self.clock.now()
        for sink in self.sinks:
            sink.write(name, utime, data)

    def _publish(self, channel: Channel, utime: int, message: Message) -> None:
        """Publish a message returned by the firing stage."""
        if utime != self._stamp and channel.name in self._plain:
            raise ValueError("it has a stamp of its own, but feeds a plain input: read it as Latest or Since")
        try:
            data = encode(message, utime, self.next_seq(channel.name))
        except EncodeError as error:
            raise ValueError(str(error)) from error
        if isinstance(message, GuardState):
            self.guard_states[channel.stage] = message
        if (outlet := self.outlets.get(channel.ref)) is not None:
            outlet.publish(message, data, utime, self._firing.birth_s, self._firing.origin_s)
        if channel.name in self._readers:
            self._bus.publish(channel.name, data)
        self.record(channel.name, data)

    def _subscribe(self) -> None:
        """Subscribe once to each channel of this process that a stage consumes."""
        for channel in self.graph.channels.values():
            if channel.name in self._readers and channel.ref not in self.graph.inputs:
                self._bus.subscribe(channel.name, partial(self._receive, channel))

    def _receive(self, channel: Channel, name: str, data: bytes) -> None:
        try:
            utime, seq, message = decode(channel.message, data)
        except DecodeError as error:
            raise DecodeError(f"stage '{channel.stage}': output '{channel.port}' is {error}") from error
        now_s = self.clock.now_s()
        for unit, port in self._readers[name]:
            unit.deliver(port, utime, message.twin(), self._firing.birth_s, now_s, seq)

    def _note_firing(self, unit: LiveUnit, utime: int, age_s: float, used: Sequence[Used]) -> None:
        """Keep a firing for the log until the run is idle: no command waits for the log."""
        self._unlogged.append((self.clock.now(), unit.node.name, utime, age_s, used))
        if len(self._unlogged) >= _MAX_UNLOGGED:
            self._log_firings()

    def _log_firings(self) -> None:
        for at_us, stage, utime, age_s, used in self._unlogged:
            if self._firing_log is not None:
                data = encoded_firing(at_us, stage, utime, self.next_seq(FIRED), age_s, used)
                self._firing_log.write(FIRED, self.clock.now(), data)
        self._unlogged.clear()

    def _own_stamp(self, now_s: float) -> int:
        """Return a stamp of the run's own clock, later than all earlier ones."""
        self._newest_stamp = max(self._newest_stamp + 1, self.clock.utime_at(now_s))
        return self._newest_stamp

    def _fault_of(self, ref: str, now_s: float) -> str:
        intake = self.intakes.get(ref)
        return intake.monitor.fault(now_s) if intake is not None else ""

    def next_seq(self, channel: str) -> int:
        """Return the sequence number of a channel's next message."""
        seq = self._seqs[channel]
        self._seqs[channel] = seq + 1
        return seq


def _after_s(unit: LiveUnit) -> Callable[[int], float]:
    """Return when each firing of a source is due, in seconds after the first one."""
    return lambda firing: unit.due_us(firing) * 1e-6
