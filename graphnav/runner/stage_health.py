"""The stages and the process in the status of a run, live or in lockstep."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graphnav.runner.unit import Unit

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


def stage_statuses(units: Mapping[str, Unit], rates: Rates, elapsed_s: float) -> tuple[dict[str, Any], ...]:
    """Return the fields of ``stage_status_t`` for every stage; rates are averages over ``elapsed_s``."""
    return tuple(
        {
            "name": name,
            "use": unit.node.use,
            "steps": unit.durations.count,
            "rate_hz": rates.since(name, unit.durations.count) / elapsed_s,
            "p50_ms": unit.durations.quantile_s(0.5) * 1e3,
            "p99_ms": unit.durations.quantile_s(0.99) * 1e3,
            "deadline_ms": unit.node.deadline_ms or 0.0,
            "missed": unit.missed,
            "overtaken": unit.dropped,
        }
        for name, unit in units.items()
    )


def memory_mb() -> float:
    """Return the resident memory of this process in megabytes; 0 if the kernel does not report it."""
    try:
        return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * _PAGE_MB
    except (OSError, ValueError, IndexError):
        return 0.0
