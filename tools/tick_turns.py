"""Tick a graph by turns: ``python tools/tick_turns.py GRAPH LOG SEED`` ticks N times for each line N of its input.

It answers each line with the mean wall time and processor time of a tick, and the processor times of all, in s, as
JSON. It runs with older versions of graphnav, too, so that two versions can take turns. A run that ends begins again
with the next seed.
"""

from __future__ import annotations

import importlib
import importlib.util
import json
import os
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

_CORE = "graphnav.core" if importlib.util.find_spec("graphnav.core") else "graphnav"
"""Where this version has its modules."""


class Ticker:
    """A run whose log is complete after each turn; begun again where it ends."""

    def __init__(self, graph: str, log: Path, seed: int) -> None:
        self._graph = _module("graph").load_graph(graph, _module("catalog").Catalog())
        self._log, self._seed = log, seed
        self._begin()

    def turn(self, ticks: int) -> dict[str, Any]:
        """Tick so many times; return the mean times of a tick, with the log's, and the processor time of each, s."""
        wall_s, cpu_s = time.perf_counter(), [time.process_time()]
        until = self._graph.run.until_s or 60.0
        for _ in range(ticks):
            if self._runner.tick() or self._runner.next_utime > until * 1e6:
                self._end()
                return self.turn(ticks)
            cpu_s.append(time.process_time())
        self._writer.flush()
        wall_s, total_s = time.perf_counter() - wall_s, time.process_time() - cpu_s[0]
        each_s = [after - before for before, after in pairwise(cpu_s)]
        return {"wall_s": wall_s / ticks, "cpu_s": total_s / ticks, "each_cpu_s": each_s}

    def _begin(self) -> None:
        self._writer = _module("record").LogWriter(self._log)
        self._runner = _run(self._graph, self._writer)
        self._runner.reset(self._seed)

    def _end(self) -> None:
        getattr(self._runner, "engine", self._runner).close()
        self._writer.close()
        self._seed += 1
        self._begin()


def _module(name: str) -> Any:
    return importlib.import_module(f"{_CORE}.{name}")


def _run(graph: Any, writer: Any) -> Any:
    """Return the runner of a graph, by its name in this version."""
    runner = _module("runner")
    if hasattr(runner, "Lockstep"):
        return runner.Lockstep(graph, graph.make_stages(), [writer])
    return runner.Runner(graph, graph.make_stages(), _module("bus").Bus("memq://"), [writer])


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
