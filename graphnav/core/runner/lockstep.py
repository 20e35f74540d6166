"""The schedule of lockstep: simulated time, one tick a stamp, as fast as the machine allows or paced."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from time import perf_counter
from typing import Any

from graphnav.core.errors import StageError
from graphnav.core.graph import Channel, Graph, Node
from graphnav.core.runner.engine import Engine, Outcome, Published, Sink, Spans
from graphnav.core.runner.lockstep_inbox import LockstepInbox
from graphnav.core.runner.remote_unit import ProcessState, RemoteStage
from graphnav.core.runner.stage_calls import StageCalls
from graphnav.core.runner.unit import Unit
from graphnav.core.stage import Stage


class LockstepEngine(Engine[LockstepInbox]):
    """An engine whose stages fire with the messages of one stamp; its parameters are those of `Engine`."""

    def __init__(
        self,
        nodes: Iterable[Node],
        stages: Mapping[str, Stage | RemoteStage],
        sinks: Sequence[Sink],
        *,
        is_wired: bool = True,
        played: Collection[str] = (),
        commands: Iterable[Channel] = (),
        published: Published | None = None,
        spans: Spans | None = None,
        calls: StageCalls | None = None,
    ) -> None:
        super().__init__(
            nodes,
            stages,
            sinks,
            LockstepInbox,
            LockstepInbox.put,
            is_wired=is_wired,
            played=played,
            commands=commands,
            published=published,
            spans=spans,
            calls=calls,
        )

    def fire_at(self, unit: Unit[LockstepInbox], stamp: int) -> str | None:
        """Step a stage with the messages of a stamp; return the outcome if a source ended the run."""
        inputs = unit.inbox.take(stamp)
        if unit.node.deadline_ms is None:
            return self.fire(unit, stamp, inputs, 0.0)
        ready_s = perf_counter()
        outcome = self.fire(unit, stamp, inputs, 0.0)
        unit.judge_deadline(ready_s, perf_counter())
        return outcome

    def fire_complete(self, unit: Unit[LockstepInbox], stamp: int) -> None:
        """Fire a stage if its plain inputs are complete, else drop them."""
        if unit.inbox.is_complete:
            self.fire_at(unit, stamp)
        else:
            unit.inbox.discard()


class Lockstep:
    """Fires the stages of a graph tick by tick.

    A source fires at stamps ``round(k * 1e6 / rate_hz)`` microseconds, or at recorded ones; sources that are due at one
    stamp fire in the graph's order, then every other stage whose plain inputs are complete, in firing order. Joins that
    are still incomplete at the end of the tick are dropped and counted.
    """

    def __init__(
        self,
        graph: Graph,
        stages: Mapping[str, Stage | RemoteStage],
        sinks: Sequence[Sink],
        spans: Spans | None = None,
        calls: StageCalls | None = None,
    ) -> None:
        """Wire ``stages`` (by name) of ``graph``; every message also goes to the ``sinks``."""
        spans = spans or Spans()
        self.graph = graph
        self.engine = LockstepEngine(graph.nodes, stages, sinks, commands=graph.commands, spans=spans, calls=calls)
        self.tick: Callable[[], str | None] = spans.tick(self._tick)
        """Fires everything that is due at the next stamp; returns the outcome if a source ended the run, and raises
        StageError if a stage raised, or returned something invalid."""
        self.while_waiting: Callable[[], None] = lambda: None
        """Called once a second at least while a reset or a tick waits for another process."""
        self._order = [self.engine.units[node.name] for node in graph.order]
        self._sources = [self.engine.units[node.name] for node in graph.sources]
        self._due: list[tuple[int, int, int]] = []

    @property
    def process_states(self) -> Sequence[ProcessState]:
        """How the processes of its stages are; empty: they live in this one."""
        return ()

    @property
    def processes(self) -> dict[str, Any] | None:
        """Fate of the processes of its stages, for the summary; None: they live in this one."""
        return None

    def hold(self, stages: Collection[str]) -> bool:  # noqa: ARG002 - between two ticks none makes a step
        """Begin no step of these stages until the next change; return whether they make none at the moment."""
        return True

    def change(self, graph: Graph, nodes: Iterable[Node], stages: Mapping[str, Stage]) -> list[StageError]:
        """Let other stages take over from the next tick on, as `Engine.change` does; ``graph``: with them."""
        failed = self.engine.change(graph, nodes, stages)
        self.graph = graph
        self._order = [self.engine.units[node.name] for node in graph.order]
        return failed

    @property
    def next_utime(self) -> int:
        """The stamp of the next tick, microseconds."""
        return self._due[0][0]

    def reset(self, seed: int) -> None:
        """Reset the state of every stage from ``seed``, and the clock to 0.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        self.engine.reset(seed)
        self._due = [(0, place, 0) for place in range(len(self._sources))]
        heapq.heapify(self._due)

    def run(self, until_s: float | None = None, before_tick: Callable[[int], bool] = lambda _: True) -> str:
        """Tick until a source ends the run, ``until_s`` has passed, or ``before_tick`` returns False.

        ``before_tick`` gets the stamp of the next tick; it implements progress, pace and Ctrl-C.
        """
        until = None if until_s is None else round(until_s * 1e6)
        while True:
            if until is not None and self.next_utime > until:
                return Outcome.TIMEOUT
            if not before_tick(self.next_utime):
                return Outcome.STOPPED
            if outcome := self.tick():
                return outcome

    def _tick(self) -> str | None:
        outcome = self._fire_sources()
        for unit in self._order:
            self.engine.fire_complete(unit, self.engine.utime)
        self.engine.ticks += 1
        return outcome

    def _fire_sources(self) -> str | None:
        """Begin the next tick: fire the sources that are due; return the outcome if one of them ended the run."""
        self.engine.utime = stamp = self._due[0][0]
        outcome = None
        while self._due[0][0] == stamp:
            _, place, k = heapq.heappop(self._due)
            source = self._sources[place]
            outcome = self.engine.fire_at(source, stamp) or outcome
            heapq.heappush(self._due, (source.due_us(k + 1), place, k + 1))
        return outcome
