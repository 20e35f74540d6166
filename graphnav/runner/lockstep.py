"""Run a graph in lockstep: simulated time, one tick per stamp, as fast as the machine allows or paced."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Mapping, Sequence
from enum import StrEnum

from graphnav.bus import Bus
from graphnav.graph import Graph
from graphnav.runner.owned_stages import Sink
from graphnav.runner.wired_stages import WiredStages
from graphnav.stage import Stage


class Outcome(StrEnum):
    """The outcome of a run."""

    GOAL = "goal"
    CONTACT = "contact"
    TIMEOUT = "timeout"
    END = "end"
    STOPPED = "stopped"
    FAILED = "failed"


class Runner(WiredStages):
    """Owns the stages of a graph and the bus, and fires by the firing rule.

    A source fires at stamps ``round(k * 1e6 / rate_hz)`` microseconds, or at recorded ones; sources that are due at one
    stamp fire in the graph's order, then every other stage whose plain inputs are complete, in firing order. Joins that
    are still incomplete at the end of the tick are dropped and counted.
    """

    def __init__(self, graph: Graph, stages: Mapping[str, Stage], bus: Bus, sinks: Sequence[Sink]) -> None:
        """Wire ``stages`` (by name) of ``graph`` over ``bus``; every message also goes to the ``sinks``."""
        super().__init__(graph, stages, bus, sinks)
        self._order = [self._units[node.name] for node in graph.order]
        self._due: list[tuple[int, int, int]] = []
        self._sources = [self._units[node.name] for node in graph.sources]

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
        super().reset(seed)
        self._due = [(0, place, 0) for place in range(len(self._sources))]
        heapq.heapify(self._due)

    def tick(self) -> str | None:
        """Fire everything that is due at the next stamp; return the outcome if a source ended the run.

        Raises
        ------
        StageError
            A stage raised, or returned something invalid.
        """
        self.utime = stamp = self._due[0][0]
        outcome = None
        while self._due[0][0] == stamp:
            _, place, k = heapq.heappop(self._due)
            outcome = self._fire(self._sources[place], stamp) or outcome
            heapq.heappush(self._due, (self._due_us(place, k + 1), place, k + 1))
        for unit in self._order:
            self._fire_complete(unit, stamp)
        self.ticks += 1
        return outcome

    def _due_us(self, place: int, firing: int) -> int:
        return self._sources[place].due_us(firing)

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
