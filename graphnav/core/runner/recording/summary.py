"""The durable record of a run: what happened, what it cost, what it scored."""

from __future__ import annotations

import importlib.metadata
import json
import math
import platform
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

from graphnav.core.machine.files import write_atomically
from graphnav.core.machine.instruction_set import used_instruction_set
from graphnav.core.runner.unit import Unit

_RECORDED = ("graphnav", "numpy", "opencv-python-headless", "scikit-learn", "lcm", "pymunk", "pluggy", "pyyaml")


@dataclass(frozen=True)
class StageSteps:
    """Statistics of one stage: ``dropped`` counts sets of inputs that stayed incomplete.

    ``missed``: steps that took longer than the stage's deadline, None where it has none.
    """

    use: str
    steps: int
    p50_ms: float
    p99_ms: float
    dropped: int
    missed: int | None = None


@dataclass(frozen=True)
class Summary:
    """Content of ``summary.json``: ``failure`` is the error of a failed run, ``scores`` are the metrics by stage."""

    INSTRUCTION_SET: ClassVar[str] = "instruction set"
    outcome: str
    failure: str
    graph: str
    seed: int
    until_s: float | None
    frames: int
    sim_s: float
    wall_s: float
    stages: dict[str, StageSteps]
    scores: dict[str, dict[str, float]]
    notices: list[str]
    tap_dropped: int
    run_id: str
    versions: dict[str, str]
    behind_s: float = 0.0
    """How far the run ended behind the wall clock, seconds: of a paced one its pace, of a live one its latest timer."""
    cause: str = ""
    """The failure without the time at which it happened: the same for runs that failed for the same reason."""
    changes: list[dict[str, Any]] = field(default_factory=list)
    """The stages that were rebuilt while the run went on: when, seconds from the start, as what, and the request."""
    processes: dict[str, Any] | None = None
    """Of a run in several processes: by name, the stages of each, and how it ended before the run did."""
    live: dict[str, Any] | None = None
    """Of a live run: its URL, inputs, outputs and edges as in `Status`, missed deadlines, what the log has dropped."""

    def write(self, path: Path) -> None:
        """Write it as JSON; raises GraphnavError, and leaves no part of it, if the disk refuses."""
        write_atomically(path, json.dumps(self.as_json(), indent=1) + "\n")

    def as_json(self) -> dict[str, Any]:
        """Return it as JSON can hold it; a number that is not finite becomes null."""
        return {key: _finite(value) for key, value in asdict(self).items()}

    @staticmethod
    def versions_here() -> dict[str, str]:
        """Return the versions that could make two machines differ."""
        return dict(_versions())

    @staticmethod
    def scores_of(
        units: Mapping[str, Unit[Any]], noted: Callable[[], AbstractContextManager[None]]
    ) -> dict[str, dict[str, float]]:
        """Return the metrics of every stage that declares some.

        ``noted``: returns a context that keeps the StageError of a stage whose summary fails, or holds what the stage
        does not declare; the metrics of the other stages are returned.
        """
        scores = {}
        for name, unit in units.items():
            with noted():
                metrics = unit.metrics()
                if metrics is not None:
                    scores[name] = metrics
        return scores


def steps_of(units: Mapping[str, Unit[Any]]) -> dict[str, StageSteps]:
    """Return what each stage did."""
    return {
        name: StageSteps(
            unit.node.use,
            unit.durations.count,
            round(unit.durations.quantile_s(0.5) * 1e3, 4),
            round(unit.durations.quantile_s(0.99) * 1e3, 4),
            unit.inbox.dropped,
            None if unit.node.deadline_ms is None else unit.missed,
        )
        for name, unit in units.items()
    }


@cache
def _versions() -> dict[str, str]:
    """Return them as they were when this process first asked: what it has loaded does not change."""
    found = {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "libc": " ".join(platform.libc_ver()),
        Summary.INSTRUCTION_SET: used_instruction_set(),
    }
    for name in _RECORDED:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def _finite(value: object) -> object:
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_finite(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
