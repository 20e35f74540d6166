"""The schedule of live runs: stages fire on the arrival of inputs, sources and timers on the wall clock."""

from __future__ import annotations

import math
import threading
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

from graphnav import Graph, GuardState, LiveSource, Message, Stage
from graphnav.core.codec import encode
from graphnav.core.errors import StageError
from graphnav.core.graph import Channel, Node
from graphnav.core.messages import Fired
from graphnav.core.runner import (
    ArrivalTimer,
    Encoded,
    Engine,
    LiveInbox,
    MatchedSet,
    Outcome,
    ProcessState,
    RemoteStage,
    Sink,
    StageCalls,
    Taken,
    Timer,
    Unit,
    decoded,
)
from graphnav.core.stage import Port, tell_wake
from graphnav.live.clock import LiveClock
from graphnav.live.inputs.intake import Intake, Received
from graphnav.live.outlet import Outlet

_MAX_UNLOGGED = 32
"""Maximum number of firings pending for the log if the run is never idle."""
_MAX_WAIT_S = 0.05
"""Interval of the checks whether the run should stop while no input arrives."""


class StampedNow:
    """Writes messages to several sinks, stamped now: senders' clocks may differ.

    ``sent_us``: when the message that is written next was sent, None if it was not: then that is its time, so that no
    receiver logs it earlier.
    """

    def __init__(self, sinks: Sequence[Sink], clock: LiveClock) -> None:
        self.sent_us: int | None = None
        self._sinks, self._clock = sinks, clock

    def write(self, channel: str, _utime: int, data: bytes) -> None:
        """Write one message."""
        now = self._clock.now() if self.sent_us is None else self.sent_us
        self.sent_us = None
        for sink in self._sinks:
            sink.write(channel, now, data)


class LiveSchedule:
    """Fires the stages of a graph in a live run; one thread fires them all.

    At every turn one stage fires: a timer (``every_ms``) that is due, else a stage whose plain inputs are complete,
    the one nearest to the end of the graph first, else a source that is due. The kinds take turns, so that a timer or a
    source that takes longer than its period does not starve other stages. Messages that a slow stage misses are
    overtaken, not queued. ``sinks`` get every message, stamped now, ``firings`` the inputs of every step, for replays.
    """

    def __init__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage | RemoteStage],
        clock: LiveClock,
        intakes: Sequence[Intake],
        wake: threading.Event,
        sinks: Sequence[Sink],
        firings: Sink | None,
        calls: StageCalls | None = None,
    ) -> None:
        self.graph = graph
        self.clock = clock
        self.steps: dict[str, float] = {}
        """The stages that make a step and when it began, monotonic seconds, for other threads."""
        self.is_idle = False
        """Whether no stage makes a step, and nothing that has arrived waits for one that could fire."""
        self.sink = StampedNow(sinks, clock)
        """Takes every message of the run, and its status."""
        self.outlets: dict[str, Outlet] = {}
        """By the reference of the channel that is sent."""
        self.guard_states: dict[str, GuardState] = {}
        """The newest state of each guard, by its stage."""
        self.intakes = {intake.source.channel.ref: intake for intake in intakes}
        self.engine = Engine(
            graph.nodes,
            stages,
            [self.sink],
            self._inbox,
            self._arrived,
            published=self._send,
            begin_us=clock.start_utime,
            calls=calls,
        )
        self._firing_log = firings
        self._unlogged: list[tuple[int, str, int, Taken]] = []
        self._wake = wake
        self._newest_stamp = clock.start_utime
        self._order = [self.engine.units[node.name] for node in reversed(graph.order)]
        self._clocked: list[tuple[Timer, Unit[LiveInbox]]] = []
        self._sources: list[tuple[Timer, Unit[LiveInbox]]] = []
        self._source_was_last = self._timer_was_last = False
        self._birth_s = self._origin_s = math.nan
        """Of what arrives and is sent at the moment: see `LiveInbox`."""
        for stage in stages.values():
            if isinstance(stage, LiveSource):
                tell_wake(stage, wake.set)

    @property
    def skipped(self) -> int:
        """Firings of sources skipped because they were late by more than a period."""
        return sum(timer.skipped for timer, _ in self._sources)

    @property
    def live_sources(self) -> Sequence[tuple[ArrivalTimer, Unit[LiveInbox]]]:
        """The sources that are fired by what arrives from outside."""
        return [(timer, unit) for timer, unit in self._sources if isinstance(timer, ArrivalTimer)]

    @property
    def process_states(self) -> Sequence[ProcessState]:
        """How the processes of its stages are; empty: they live in this one."""
        return ()

    def overtaken(self) -> Counter[str]:
        """Return the number of overtaken messages by edge, ``stage.port``, without zeros."""
        counts = (
            (f"{name}.{port}", n)
            for name, unit in self.engine.units.items()
            for port, n in unit.inbox.join.overtaken.items()
        )
        return Counter({edge: count for edge, count in counts if count})

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        self.engine.reset(seed)
        now_s = self.clock.now_s()
        units = self.engine.units
        self._clocked = [
            (Timer(Timer.every(u.node.every_ms / 1e3), now_s), u) for u in units.values() if u.node.every_ms
        ]
        sources = [units[node.name] for node in self.graph.sources]
        self._sources = [(self._source_timer(unit, now_s), unit) for unit in sources]

    def hold(self, stages: Collection[str]) -> bool:  # noqa: ARG002 - between two turns none makes a step
        """Begin no step of these stages until the next change; return whether they make none at the moment."""
        return True

    def change(self, graph: Graph, nodes: Iterable[Node], stages: Mapping[str, Stage]) -> list[StageError]:
        """Let other stages take over from their next firing on, as `Engine.change` does; ``graph``: with them."""
        self.engine.utime = self.clock.now()
        failed = self.engine.change(graph, nodes, stages)
        self.graph = graph
        self._order = [self.engine.units[node.name] for node in reversed(graph.order)]
        return failed

    def is_needed(self, ref: str) -> bool:
        """Whether a stage cannot fire without this input, by reference."""
        return not all(port.latest for _, port in self._readers(self.intakes[ref].source.channel.name))

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
        self.is_idle = True
        while True:
            if self.clock.now_s() >= end_s:
                return Outcome.TIMEOUT
            if not keep_going():
                return Outcome.STOPPED
            outcome = self._take_results()
            if outcome is None:
                if self._wake.is_set() or not fired:
                    self._wake.clear()
                    self._take_inputs()
                outcome, fired = self._turn()
            self.is_idle = not fired and not self.steps
            if outcome is not None:
                self._finish()
                return outcome
            if fired:
                continue
            if not self.steps:
                if is_over():
                    return Outcome.END
                self._log_firings()
            self._wait(self._wait_s(end_s))

    def settle(self) -> None:
        """Wait a little for steps that have not ended when the run has; what they publish goes to the log alone."""

    def close(self) -> None:
        """Close every stage, even if another one fails to close.

        Raises
        ------
        StageError
            The first failure, after every stage was closed.
        """
        self._log_firings()
        self.engine.utime = self.clock.now()
        self.engine.close()

    def _turn(self) -> tuple[str | None, bool]:
        """Fire one stage; return the outcome if a source ended the run, and whether a stage fired."""
        now_s = self.clock.now_s()
        was_timer, self._timer_was_last = self._timer_was_last, False
        if was_timer:
            outcome, fired = self._turn_untimed(now_s)
            if fired:
                return outcome, True
        due = [pair for pair in self._clocked if pair[0].is_due(now_s) and self._is_free(pair[1])]
        if not due:
            return self._turn_untimed(now_s)
        timer, unit = min(due, key=lambda pair: pair[0].due_s)
        timer.advance(now_s)
        self._timer_was_last = True
        return self._fire_timer(unit, now_s), True

    def _turn_untimed(self, now_s: float) -> tuple[str | None, bool]:
        """Fire a stage whose inputs are complete or a source that is due; the same result as `_turn`."""
        due = next((one for one in self._sources if one[0].is_due(now_s) and self._is_free(one[1])), None)
        if due is None or self._source_was_last:
            for unit in filter(self._is_free, self._order):
                if (matched := unit.inbox.ready(now_s, unit.patience_s)) is not None:
                    self._source_was_last = False
                    return self._fire_set(unit, matched, now_s), True
        if due is None:
            return None, False
        timer, unit = due
        utime = self.clock.utime_at(timer.due_s)
        birth_s = timer.due_s if isinstance(timer, ArrivalTimer) else now_s
        timer.advance(now_s)
        self._source_was_last = True
        return self._fire(unit, utime, unit.inbox.take_no_set(now_s, birth_s, birth_s)), True

    def _finish(self) -> None:
        """Step with the messages that the source published when it ended the run."""
        for unit in reversed(self._order):
            if (matched := unit.inbox.ready(math.inf, unit.patience_s)) is not None:
                self._fire_set(unit, matched, self.clock.now_s())

    def _fire_set(self, unit: Unit[LiveInbox], matched: MatchedSet, now_s: float) -> str | None:
        utime = self._own_stamp(now_s) if unit.inbox.is_clocked else matched.utime
        return self._fire(unit, utime, unit.inbox.take_set(matched, now_s), matched.ready_s)

    def _fire_timer(self, unit: Unit[LiveInbox], now_s: float) -> str | None:
        return self._fire(unit, self._own_stamp(now_s), unit.inbox.take_timer(now_s, unit.patience_s))

    def _fire(self, unit: Unit[LiveInbox], utime: int, taken: Taken | None, ready_s: float | None = None) -> str | None:
        """Step a stage, unless its timer found nothing to step with; ``ready_s``: when its set was complete."""
        outcome = None
        if taken is not None:
            self._note_firing(unit, utime, taken)
            outcome = self._step(unit, utime, taken, ready_s)
        self.engine.ticks += 1
        return outcome

    def _step(self, unit: Unit[LiveInbox], utime: int, taken: Taken, ready_s: float | None) -> str | None:
        self._birth_s, self._origin_s = unit.inbox.birth_s, unit.inbox.origin_s
        self.steps[unit.node.name] = self.clock.now_s()
        outcome = self.engine.fire(unit, utime, taken.inputs, taken.age_s)
        del self.steps[unit.node.name]
        if ready_s is not None:
            unit.judge_deadline(ready_s, self.clock.now_s())
        return outcome

    def is_away(self, stage: str) -> bool:  # noqa: ARG002 - here all are there
        """Whether the process of a stage is being started again."""
        return False

    def _is_free(self, _: Unit[LiveInbox]) -> bool:
        """Whether a stage would begin a step at once."""
        return True

    def _source_timer(self, unit: Unit[LiveInbox], start_s: float) -> Timer:
        if unit.node.is_live_source:
            return ArrivalTimer(unit.arrived_s, start_s)
        return Timer(_after_s(unit), start_s)

    def _take_results(self) -> str | None:
        """Publish what steps that have ended elsewhere returned; return the outcome if a source ended the run."""
        return None

    def _wait(self, timeout_s: float) -> None:
        self._wake.wait(timeout_s)

    def _wait_s(self, end_s: float) -> float:
        """Return the time until the next event other than the arrival of an input, and the end of a step."""
        now_s = self.clock.now_s()
        timers = (timer for timer, unit in (*self._clocked, *self._sources) if self._is_free(unit))
        due_s = min((timer.due_s for timer in timers), default=math.inf)
        free = filter(self._is_free, self._order)
        waking_s = min((unit.inbox.wakes_at_s(unit.patience_s) for unit in free), default=math.inf)
        return max(0.0, min(due_s, waking_s, end_s, now_s + _MAX_WAIT_S) - now_s)

    def _take_inputs(self) -> None:
        for intake in self.intakes.values():
            before = intake.overtaken
            for received in intake.take():
                self._deliver_input(intake, received)
            if intake.overtaken > before:
                for unit, port in self._readers(intake.source.channel.name):
                    if port.is_plain:
                        unit.inbox.join.overtaken[port.name] += intake.overtaken - before

    def _deliver_input(self, intake: Intake, received: Received) -> None:
        name = intake.source.channel.name
        if received.is_restart:
            self._restart([name])
        number = self.engine.number(name)
        self._birth_s = received.birth_s
        data = received.raw or encode(received.message, received.utime, number)
        self.engine.deliver_bytes(name, received.utime, number, data)
        self.engine.deliver(name, received.utime, number, received.message)
        self.sink.write(name, received.utime, data)

    def _restart(self, channels: Iterable[str]) -> None:
        """Drop what was made from channels that restart; guards fire at once without them, which is a stop."""
        restarted: dict[str, Unit[LiveInbox]] = {}
        pending = list(channels)
        while pending:
            for unit, port in self._readers(pending.pop()):
                if not port.latest and unit.node.name not in restarted:
                    restarted[unit.node.name] = unit
                    pending += [one.name for one in unit.node.outputs.values()]
        for unit in restarted.values():
            self._drop(unit)
        for _, unit in self._clocked:
            if unit.node.name in restarted:
                self._fire_timer(unit, self.clock.now_s())

    def _drop(self, unit: Unit[LiveInbox]) -> None:
        """Drop what waits for a stage."""
        unit.inbox.restart()

    def withhold_commands(self, *, is_withheld: bool) -> None:
        """Give guards no command from now on, or again: one that is not sent must not count as driven."""
        for unit in self.engine.units.values():
            if unit.node.stage_class.is_guard:
                unit.inbox.withhold(is_withheld=is_withheld)

    def _readers(self, channel: str) -> Sequence[tuple[Unit[LiveInbox], Port]]:
        return self.engine.readers.get(channel, ())

    def _inbox(self, node: Node) -> LiveInbox:
        return LiveInbox(node, self.graph.queues, self._fault_of)

    def _arrived(self, inbox: LiveInbox, port: Port, utime: int, number: int, message: Message) -> None:
        inbox.put(port, utime, number, message, self._birth_s, self.clock.now_s())

    def _send(self, channel: Channel, utime: int, _number: int, message: Message | Encoded, data: bytes) -> None:
        """Send an output to other programs, and keep the state of a guard."""
        outlet = self.outlets.get(channel.ref)
        is_state, is_of_another = issubclass(channel.message, GuardState), isinstance(message, Encoded)
        if isinstance(message, Encoded) and (is_state or (outlet is not None and outlet.target.adapter is not None)):
            message = decoded(channel, data)[2]
        if isinstance(message, GuardState):
            self.guard_states[channel.stage] = message
        if outlet is not None:
            now = self.clock.now()
            outlet.publish(message, data, utime, self._birth_s, self._origin_s)
            if not is_of_another:  # one of another process is logged in its turn
                self.sink.sent_us = now

    def _note_firing(self, unit: Unit[LiveInbox], utime: int, taken: Taken) -> None:
        """Keep a firing for the log until the run is idle: no command waits for the log."""
        if self._firing_log is not None:
            self._unlogged.append((self.clock.now(), unit.node.name, utime, taken._replace(inputs={})))
            if len(self._unlogged) >= _MAX_UNLOGGED:
                self._log_firings()

    def _log_firings(self) -> None:
        for at_us, stage, utime, taken in self._unlogged:
            if self._firing_log is not None:
                data = taken.encoded(at_us, stage, utime, self.engine.number(Fired.CHANNEL))
                self._firing_log.write(Fired.CHANNEL, self.clock.now(), data)
        self._unlogged.clear()

    def _own_stamp(self, now_s: float) -> int:
        """Return a stamp of the run's own clock, later than all earlier ones."""
        self._newest_stamp = max(self._newest_stamp + 1, self.clock.utime_at(now_s))
        return self._newest_stamp

    def _fault_of(self, ref: str, now_s: float) -> str:
        intake = self.intakes.get(ref)
        return intake.monitor.fault(now_s) if intake is not None else ""


def _after_s(unit: Unit[LiveInbox]) -> Callable[[int], float]:
    """Return when each firing of a source is due, in seconds after the first one."""
    return lambda firing: unit.due_us(firing) * 1e-6
