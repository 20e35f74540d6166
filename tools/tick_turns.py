"""Tick a graph by turns: ``python tools/tick_turns.py GRAPH LOG SEED`` ticks N times for each line N of its input.

It answers each line with the wall time and the processor time of a tick, in s, as JSON, and runs with older versions of
graphnav, too, so that two versions can take turns. A run that ends begins again with the next seed.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import time
from pathlib import Path
from typing import Any

from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph
from graphnav.core.record import LogWriter


class Ticker:
    """A run whose log is complete after each turn; begun again where it ends."""

    def __init__(self, graph: str, log: Path, seed: int) -> None:
        self._graph = load_graph(graph, Catalog())
        self._log, self._seed = log, seed
        self._begin()

    def turn(self, ticks: int) -> dict[str, float]:
        """Tick so many times; return the mean wall and processor time of a tick, s."""
        wall_s, cpu_s = time.perf_counter(), time.process_time()
        until = self._graph.run.until_s or 60.0
        ended = False
        for _ in range(ticks):
            if self._runner.tick() or self._runner.next_utime > until * 1e6:
                ended = True
                break
        self._writer.flush()
        wall_s, cpu_s = time.perf_counter() - wall_s, time.process_time() - cpu_s
        if ended:
            self._end()
            return self.turn(ticks)
        return {"wall_s": wall_s / ticks, "cpu_s": cpu_s / ticks}

    def _begin(self) -> None:
        self._writer = LogWriter(self._log)
        self._runner = _run(self._graph, self._writer)
        self._runner.reset(self._seed)

    def _end(self) -> None:
        getattr(self._runner, "engine", self._runner).close()
        self._writer.close()
        self._seed += 1
        self._begin()


def _run(graph: Graph, writer: LogWriter) -> Any:
    """Return the runner of a graph, by its name in this version."""
    module = importlib.import_module("graphnav.core.runner")
    if hasattr(module, "Lockstep"):
        return module.Lockstep(graph, graph.make_stages(), [writer])
    return module.Runner(graph, graph.make_stages(), Bus("memq://"), [writer])


def main() -> None:
    """Serve turns until the input ends, on one core."""
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    graph, log, seed = sys.argv[1:]
    ticker = Ticker(graph, Path(log), int(seed))
    for line in sys.stdin:
        sys.stdout.write(json.dumps(ticker.turn(int(line))) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
