"""The processes of a run, and which way each edge between its stages takes, from its status."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graphnav import Status
from graphnav.core.cli import counted
from graphnav.core.errors import shown_name
from graphnav.core.machine import offset_text, span_text
from graphnav.core.tables import Cell, Tone

PROCESS = ("process", "stages", "pid", "state", "restarts", "cpu", "memory", "host")
EDGE = ("edge", "reads", "way", "overtaken")
_OWN = "(run)"
"""The process of the run itself, which has no name."""
_TONES: Mapping[str, Tone] = {"ready": "", "given up": "bad"}


class Processes:
    """Where the stages of a run live; false if all of them live in its own process."""

    def __init__(self, status: Status) -> None:
        self._status = status
        self._of_stage = {str(stage): str(one["name"]) for one in status.processes for stage in one["stages"]}

    def __bool__(self) -> bool:
        return bool(self._status.processes)

    @property
    def has_hosts(self) -> bool:
        """Whether one of them lives on another host."""
        return any(one["host"] for one in self._status.processes)

    def of(self, stage: str) -> str:
        """Return the process of a stage; inputs, which are no stages, come from the run's own."""
        return self._of_stage.get(stage, "")

    def way(self, edge: Mapping[str, Any]) -> tuple[str, str]:
        """Return the processes of the writer and the reader of an edge."""
        return self.of(str(edge["channel"]).partition(".")[0]), self.of(str(edge["name"]).partition(".")[0])

    def rows(self) -> Iterator[Sequence[object]]:
        """Yield the rows of the table of processes."""
        for one in self._status.processes:
            yield (
                shown_process(one["name"]),
                ", ".join(map(shown_name, one["stages"])),
                one["pid"] or "",
                Cell(shown_name(one["state"]), _TONES.get(one["state"], "warning")),
                Cell(str(one["restarts"]), "warning" if one["restarts"] else ""),
                f"{100.0 * one['cpu_ratio']:.0f} %",
                f"{one['memory_mb']:.0f} MB",
                Cell(shown_host(one), "warning" if one["clock_steps"] else ""),
            )

    def edge_rows(self) -> Iterator[Sequence[object]]:
        """Yield the rows of the table of edges."""
        for edge in self._status.edges:
            writer, reader = map(shown_process, self.way(edge))
            yield (
                shown_name(edge["name"]),
                shown_name(edge["channel"]),
                f"within {reader}" if writer == reader else f"{writer} → {reader}",
                Cell(str(edge["overtaken"]), "warning" if edge["overtaken"] else "") if self._status.live else "",
            )


def shown_process(name: str) -> str:
    """Return the name of a process as a terminal may print it."""
    return shown_name(name) or _OWN


def shown_host(process: Mapping[str, Any]) -> str:
    """Return the host of a process with its clock as a terminal may print it, empty for this machine."""
    if not process["host"]:
        return ""
    away_s, offset_s, error_s = 1e-3 * process["round_trip_ms"], process["clock_offset_s"], process["clock_error_s"]
    if not all(map(math.isfinite, (away_s, offset_s, error_s))):
        told = ["not measured"]
    else:
        drift_ppm = process["clock_drift_ppm"]
        clock = offset_text(offset_s, error_s, drift_ppm if math.isfinite(drift_ppm) else None)
        told = [f"{span_text(away_s)} away", f"clock {clock}"]
    if process["clock_steps"]:
        told.append(f"set {counted(process['clock_steps'], 'time')}")
    return f"{shown_name(process['host'])}: {', '.join(told)}"
