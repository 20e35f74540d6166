"""The status of a run for viewers, `graphnav.status`: its stages, edges and processes; of lockstep all of it."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from graphnav.core.codec import encode
from graphnav.core.graph import Graph, Node
from graphnav.core.machine.system import is_linux
from graphnav.core.messages import Status
from graphnav.core.runner.engine import Engine, Sink
from graphnav.core.runner.remote_unit import ProcessState
from graphnav.core.runner.unit import Unit

_PERIOD_S = 1.0
_MIN_S = 0.1
"""Processor time, which the kernel counts in hundredths of a second, is not told of a shorter time."""
_USER, _SYSTEM, _START, _RESIDENT = 11, 12, 19, 21
"""Fields of /proc/PID/stat behind the name."""


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


class _Load(NamedTuple):
    """Load of a process; times are seconds, the start is one since the machine's."""

    used_s: float
    start_s: float
    memory_mb: float


def _load_of(pid: int) -> _Load:
    """Return the load of a process, nothing where the kernel does not report it."""
    if not is_linux():
        return _Load(0.0, 0.0, 0.0)
    try:
        page_mb, ticks_hz = os.sysconf("SC_PAGE_SIZE") / 1e6, os.sysconf("SC_CLK_TCK")
        text = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8", errors="replace")
        fields = [int(word) for word in text.rpartition(") ")[2].split()[1:]]
        used, start, resident = fields[_USER - 1] + fields[_SYSTEM - 1], fields[_START - 1], fields[_RESIDENT - 1]
        return _Load(used / ticks_hz, start / ticks_hz, resident * page_mb)
    except (OSError, ValueError, IndexError):
        return _Load(0.0, 0.0, 0.0)


def memory_mb() -> float:
    """Return the resident memory of this process in megabytes; 0 if the kernel does not report it."""
    return _load_of(os.getpid()).memory_mb


class _Sample(NamedTuple):
    """The processor time of a process until a moment, and the ratio that was told then."""

    used_s: float
    at_s: float
    ratio: float


class ProcessStatuses:
    """Makes the fields of ``process_status_t``; processor time is an average since they were made last."""

    def __init__(self) -> None:
        self._last: dict[int, _Sample] = {}

    def make(self, states: Sequence[ProcessState], stages: Iterable[str]) -> tuple[dict[str, Any], ...]:
        """Return them, the run's own process first, where it has others; ``stages``: all of the run."""
        if not states:
            return ()
        elsewhere = {name for state in states for name in state.stages}
        own = ProcessState("", tuple(name for name in stages if name not in elsewhere), os.getpid(), "ready", 0)
        made = tuple(state._asdict() | self._load(state.pid) for state in (own, *states))
        self._last = {one["pid"]: self._last[one["pid"]] for one in made}
        return made

    def _load(self, pid: int) -> dict[str, float]:
        now_s = time.clock_gettime(time.CLOCK_BOOTTIME)
        load = _load_of(pid) if pid else _Load(0.0, now_s, 0.0)
        last = self._last.get(pid, _Sample(0.0, load.start_s, 0.0))
        if now_s - last.at_s >= _MIN_S:
            last = _Sample(load.used_s, now_s, max(0.0, load.used_s - last.used_s) / (now_s - last.at_s))
        self._last[pid] = last
        return {"cpu_ratio": last.ratio, "memory_mb": load.memory_mb}


def edge_statuses(
    nodes: Iterable[Node], overtaken: Mapping[str, int], *, has_processes: bool
) -> tuple[dict[str, Any], ...]:
    """Return the fields of ``edge_status_t`` of the edges with ``overtaken`` messages, of several processes of all."""
    read = {f"{node.name}.{i.port.name}": i.channel.ref for node in nodes for i in node.inputs if i.channel is not None}
    names = read.keys() | overtaken.keys() if has_processes else overtaken.keys()
    return tuple(
        {"name": name, "channel": read.get(name, ""), "overtaken": overtaken.get(name, 0)} for name in sorted(names)
    )


class LockstepStatus:
    """Writes a status to the tap once a second; never to the log, which contains no wall-clock measurements.

    ``dropped`` returns what the tap has dropped, ``states`` how the processes are, none where all stages live in one.
    """

    def __init__(
        self,
        graph: Graph,
        engine: Engine[Any],
        tap: Sink,
        run_id: str,
        dropped: Callable[[], int],
        states: Callable[[], Sequence[ProcessState]],
    ) -> None:
        self._graph, self._engine, self._tap, self._run_id = graph, engine, tap, run_id
        self._dropped, self._states = dropped, states
        self._start_s = self._last_s = time.monotonic()
        self._rates = Rates()
        self._processes = ProcessStatuses()
        self._count = 0

    def look(self, utime: int, behind_s: float) -> None:
        """Publish a status if the last one is a second old."""
        if time.monotonic() - self._last_s >= _PERIOD_S:
            self.publish(utime, behind_s)

    def publish(self, utime: int, behind_s: float) -> None:
        """Publish a status."""
        now_s = time.monotonic()
        elapsed_s, self._last_s = max(now_s - self._last_s, 1e-6), now_s
        units, states = self._engine.units, self._states()
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
            stages=self._rates.stage_statuses(units, elapsed_s),
            inputs=(),
            outputs=(),
            edges=edge_statuses((unit.node for unit in units.values()), {}, has_processes=bool(states)),
            processes=self._processes.make(states, units),
        )
        self._tap.write(Status.CHANNEL, utime, encode(status, utime, self._count))
        self._count += 1
