"""The task of a worker, and its result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

STALL_S = 300.0
"""So long may one call into a stage take in a study: longer than any that ends, so that no study waits for ever."""


@dataclass(frozen=True)
class Task:
    """A pending run; it needs no file but those that the graph and the plugins name."""

    folder: str
    """Where its files will be, below the study's folder."""
    graph_yaml: str
    """The resolved graph, its paths absolute."""
    graph_path: str
    """Its file, which names the run; it is not read."""
    notices: tuple[str, ...]
    seed: int
    plugins: tuple[str, ...]
    versions: Mapping[str, str]
    """The versions of the study: a machine with any other must not take part."""
    record: Literal["small", "all"] = "small"
    draws: bool = False
    """Whether its pictures are drawn."""
    keeps_log: bool = True
    stall_s: float = STALL_S
    """The longest time that one call into a stage may take, seconds of wall time."""


@dataclass(frozen=True)
class Result:
    """The result of a task: its files, or the reason why there are none."""

    task: Task
    files: Mapping[str, bytes]
    """The content of the run folder, by path in it."""
    outcome: str = ""
    error: str = ""
    """An error that is not of the stages and ends the study: a full disk, another version."""
    died: bool = False
    """Whether the process that made it died."""
    last_call: str = ""
    """If it died: the last call into a stage, empty if that is not known."""
    ends_process: bool = False
    """Whether the process that made it ends now: a stage does not return, so that it can make no other run."""
