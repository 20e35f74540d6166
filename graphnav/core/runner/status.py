"""The status of a run for viewers, `graphnav.status`: its stages and its process; of lockstep all of it."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from graphnav.core.codec import encode
from graphnav.core.graph import Graph
from graphnav.core.messages import Status
from graphnav.core.runner.engine import Engine, Sink
from graphnav.core.runner.unit import Unit

_PERIOD_S = 1.0
_PAGE_MB = os.sysconf("SC_PAGE_SIZE") / 1e6


class Rates:
    """Increments of counts since the last call, by name."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()

    def since(self, name: str, count: int) -> int:
        """Return the increment of a count since the last call."""
        grown = count - self._counts[name]
        self._counts[name] = count
        return grown

    def stage_statuses(self, units: Mapping[str, Unit[Any]], elapsed_s: float) -> tuple[dict[str, Any], ...]:
        """Return the fields of ``stage_status_t`` for every stage; rates are averages over ``elapsed_s``."""
        return tuple(
            {
                "name": name,
                "use": unit.node.use,
                "steps": unit.durations.count,
                "rate_hz": self.since(name, unit.durations.count) / elapsed_s,
                "p50_ms": unit.durations.quantile_s(0.5) * 1e3,
                "p99_ms": unit.durations.quantile_s(0.99) * 1e3,
                "deadline_ms": unit.node.deadline_ms or 0.0,
                "missed": unit.missed,
                "overtaken": unit.inbox.dropped,
                "restarts": unit.restarts,
            }
            for name, unit in units.items()
        )


def memory_mb() -> float:
    """Return the resident memory of this process in megabytes; 0 if the kernel does not report it."""
    try:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * _PAGE_MB
    except (OSError, ValueError, IndexError):
        return 0.0


class LockstepStatus:
    """Writes a status to the tap once a second; never to the log, which contains no wall-clock measurements."""

    def __init__(self, graph: Graph, engine: Engine[Any], tap: Sink, run_id: str, dropped: Callable[[], int]) -> None:
        self._graph, self._engine, self._tap, self._run_id, self._dropped = graph, engine, tap, run_id, dropped
        self._start_s = self._last_s = time.monotonic()
        self._rates = Rates()
        self._count = 0

    def before_tick(self, utime: int, behind_s: float) -> None:
        """Publish a status if the last one is a second old."""
        now_s = time.monotonic()
        elapsed_s = now_s - self._last_s
        if elapsed_s < _PERIOD_S:
            return
        self._last_s = now_s
        status = Status(
            run_id=self._run_id,
            graph=self._graph.path.stem,
            live=False,
            wall_s=now_s - self._start_s,
            run_s=utime / 1e6,
            behind_s=behind_s,
            memory_mb=memory_mb(),
            tap_dropped=self._dropped(),
            log_dropped=0,
            log_fault="",
            stages=self._rates.stage_statuses(self._engine.units, elapsed_s),
            inputs=(),
            outputs=(),
            edges=(),
        )
        self._tap.write(Status.CHANNEL, utime, encode(status, utime, self._count))
        self._count += 1
