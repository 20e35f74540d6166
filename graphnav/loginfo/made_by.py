"""Which run made a log."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graphnav.codec import DecodeError, decode
from graphnav.errors import LogError
from graphnav.messages import Status
from graphnav.record import LOG, Recording
from graphnav.runner.lockstep_status import STATUS
from graphnav.runner.recording.run_recorded import SUMMARY


@dataclass(frozen=True)
class MadeBy:
    """The run that made a log, as far as the log and the summary beside it tell; None or empty if they do not.

    ``name``: of the graph's file. ``about``: its first words. ``n_stages``: None if the log holds no graph.
    """

    name: str | None = None
    about: str | None = None
    seed: int | None = None
    run_id: str | None = None
    outcome: str | None = None
    n_stages: int | None = None
    versions: dict[str, str] = field(default_factory=dict)


def made_by(recording: Recording) -> MadeBy | None:
    """Return the run that made a log, or None if nothing tells it."""
    about = recording.about
    summary = _summary(recording.path)
    if about is None and not summary:
        return None
    try:
        graph = recording.graph
    except LogError:
        graph = {}
    stages, versions = graph.get("stages"), summary.get("versions")
    return MadeBy(
        name=_text(summary.get("graph")) or _name_by_status(recording),
        about=_text(graph.get("about")),
        seed=about.seed if about is not None else _number(summary.get("seed")),
        run_id=_text(about.run_id if about is not None else None) or _text(summary.get("run_id")),
        outcome=_text(summary.get("outcome")),
        n_stages=len(stages) if isinstance(stages, dict) else None,
        versions={str(name): str(version) for name, version in versions.items()} if isinstance(versions, dict) else {},
    )


def _name_by_status(recording: Recording) -> str | None:
    """Return the name of the graph that the first status in a log is of."""
    if not recording.count(STATUS):
        return None
    try:
        return _text(decode(Status, recording.event(STATUS, 0).data)[2].graph)
    except DecodeError:
        return None


def _summary(log: Path) -> dict[str, Any]:
    """Return the summary of the run folder that a log lies in; empty if there is none that can be read."""
    if log.name != LOG:
        return {}
    try:
        found = json.loads((log.parent / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) and value else None


def _number(value: Any) -> int | None:
    return value if isinstance(value, int) else None
