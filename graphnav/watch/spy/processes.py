"""The processes of a run, and which way each edge between its stages takes, from its status."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from graphnav import Status
from graphnav.core.errors import shown_name
from graphnav.core.tables import Cell, Tone

PROCESS = ("process", "stages", "pid", "state", "restarts", "cpu", "memory")
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
