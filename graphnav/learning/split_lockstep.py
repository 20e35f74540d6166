"""The schedule of an episode: lockstep that waits in its ticks for what an agent does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from graphnav import Graph, Stage
from graphnav.core.runner import Lockstep, Sink


class SplitLockstep(Lockstep):
    """Lockstep whose tick has two halves: all that fires before the agent, and the agent with all that fires after it.

    The stages fire as in a tick of `Lockstep`, so that the same actions give the same messages.
    """

    def __init__(self, graph: Graph, stages: Mapping[str, Stage], sinks: Sequence[Sink], agent: str) -> None:
        super().__init__(graph, stages, sinks)
        self._agent = self.engine.units[agent]
        place = self._order.index(self._agent)
        self._before, self._after = self._order[:place], self._order[place + 1 :]
        self.outcome: str | None = None
        """How a source ended the run in this tick, None while it goes on."""

    def begin(self) -> Mapping[str, Any] | None:
        """Begin the next tick; return the agent's inputs by port, None if they are not complete.

        Raises
        ------
        StageError
            A stage raised, or returned something invalid.
        """
        self.outcome = self._fire_sources()
        for unit in self._before:
            self.engine.fire_complete(unit, self.engine.utime)
        inbox = self._agent.inbox
        if inbox.is_complete:
            return inbox.take(self.engine.utime)
        inbox.discard()
        return None

    def end(self, inputs: Mapping[str, Any] | None) -> None:
        """End the tick: fire the agent with these inputs, not at all with None, and what comes after it.

        Raises
        ------
        StageError
            A stage raised, or returned something invalid.
        """
        if inputs is not None:
            self.engine.fire(self._agent, self.engine.utime, dict(inputs), 0.0)
        for unit in self._after:
            self.engine.fire_complete(unit, self.engine.utime)
        self.engine.ticks += 1
