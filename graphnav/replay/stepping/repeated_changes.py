"""Let stages take over in a replay when they did in the run."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from typing import Any

from graphnav import Graph
from graphnav.core.messages import Changed
from graphnav.core.runner import Engine, Sink, seed_of
from graphnav.replay.log.changes import MadeChange


class RepeatedChanges:
    """Changes stages of an ``engine``; ``sinks``, logs of the replay, get the messages that tell of it."""

    def __init__(self, changes: Iterable[MadeChange], engine: Engine[Any], sinks: Sequence[Sink]) -> None:
        self._pending, self._engine, self._sinks = deque(changes), engine, sinks

    def make(self, utime: int) -> Graph | None:
        """Make the changes up to a time; return the complete graph from then on, None if nothing has changed.

        Raises
        ------
        StageError
            A stage cannot be reset.
        """
        graph = None
        while self._pending and self._pending[0].at_us <= utime:
            change = self._pending.popleft()
            graph = change.graph
            self._engine.change(graph, change.nodes, change.stages)
            for node in change.nodes:
                self._engine.units[node.name].reset(graph.run.seed, seed_of(graph.run.seed, node.name))
            for data in change.data:
                for sink in self._sinks:
                    sink.write(Changed.CHANNEL, utime, data)
        return graph
