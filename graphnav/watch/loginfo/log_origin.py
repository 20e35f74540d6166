"""The run that produced a log."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graphnav import Recording, Status
from graphnav.core.codec import DecodeError, decode
from graphnav.core.errors import LogError
from graphnav.core.machine import read_json
from graphnav.core.record import parts_of
from graphnav.core.run_folder import RunFolder


@dataclass(frozen=True)
class LogOrigin:
    """The run that produced a log, read from the log and from the run folder's summary; None or empty if unknown.

    ``name``: stem of the graph's file. ``about``: its description. ``n_stages``: None if the log holds no graph.
    """

    name: str | None = None
    about: str | None = None
    seed: int | None = None
    run_id: str | None = None
    outcome: str | None = None
    n_stages: int | None = None
    versions: dict[str, str] = field(default_factory=dict)


def origin_of(recording: Recording) -> LogOrigin | None:
    """Return the run that produced a log, None if unknown."""
    about = recording.about
    summary = _summary(recording.path)
    if about is None and not summary:
        return None
    try:
        graph = recording.graph
    except LogError:
        graph = {}
    stages, versions = graph.get("stages"), summary.get("versions")
    return LogOrigin(
        name=_string_or_none(summary.get("graph")) or _name_by_status(recording),
        about=_string_or_none(graph.get("about")),
        seed=about.seed if about is not None else _number(summary.get("seed")),
        run_id=_string_or_none(about.run_id if about is not None else None) or _string_or_none(summary.get("run_id")),
        outcome=_string_or_none(summary.get("outcome")),
        n_stages=len(stages) if isinstance(stages, dict) else None,
        versions={str(name): str(version) for name, version in versions.items()} if isinstance(versions, dict) else {},
    )


def _name_by_status(recording: Recording) -> str | None:
    """Return the graph's name from the first status message in a log."""
    if not recording.count(Status.CHANNEL):
        return None
    try:
        return _string_or_none(decode(Status, recording.event(Status.CHANNEL, 0).data)[2].graph)
    except DecodeError:
        return None


def _summary(log: Path) -> dict[str, Any]:
    """Return the summary of the run folder of a log or of a part of it; empty if it is missing or unreadable."""
    if log not in parts_of(log.with_name(RunFolder.LOG)):
        return {}
    try:
        found = read_json(log.parent / RunFolder.SUMMARY)
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _string_or_none(value: Any) -> str | None:
    return value if isinstance(value, str) and value else None


def _number(value: Any) -> int | None:
    return value if isinstance(value, int) else None
