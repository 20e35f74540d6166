"""A task of a worker, and one run made of it, on any machine."""

from __future__ import annotations

import platform
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

from graphnav import Graph, GraphnavError, Recording, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.errors import DrawingError, LogError, StageError
from graphnav.core.graph import graph_of
from graphnav.core.pictures import drawing
from graphnav.core.report import LogPictures
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome, StallLimit, Summary, difference_here, run_recorded
from graphnav.core.spec import RecordOption
from graphnav.studies import parameters

IDLE_S = 60.0
"""A process that is idle for this long exits: on a cluster it is not notified of the end of the study."""
STALL_S: float = parameters.STALL_S.default
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
    record: RecordOption = "small"
    """The messages that its log keeps."""
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
    took_s: float = 0.0
    """Wall time from its stages to its files; what a process does once, as imports, is left out."""
    set_up_s: float = 0.0
    """The part of it that is not spent driving: most of it makes the world, once for the runs through it in a row."""
    ends_process: bool = False
    """Whether the process that made it ends now: a stage does not return, so that it can make no other run."""


ENDING = "end.png"
"""The picture of how a run ended: the map, and the panels of the last frame."""
NOT_DRAWN = "not_drawn.txt"
"""Why pictures are missing, in one line; only where some are."""


def perform(task: Task, scratch: Path, send: Callable[[Result], None] = lambda _: None) -> Result:
    """Make a run in the empty folder ``scratch`` and return its files; a failing stage is a result like any other.

    ``send`` gets the result of a run with a stage that does not return, before the process ends.
    """
    try:
        return _perform(task, scratch, send)
    except LogError as error:
        cause = error.__cause__
        said = f"cannot write into {scratch.parent}: {cause.strerror}" if isinstance(cause, OSError) else str(error)
        return Result(task, {}, error=said)
    except (GraphnavError, OSError) as error:
        return Result(task, {}, error=str(error))


def _perform(task: Task, scratch: Path, send: Callable[[Result], None]) -> Result:
    study = _study(task.plugins, tuple(task.versions.items()))
    catalog, graph = study.catalog, study.graph(task)
    errors: list[GraphnavError] = []

    def on_stall(summary: Summary) -> None:
        send(replace(_result(task, scratch, summary.outcome), ends_process=True))

    stall = StallLimit(task.stall_s, on_stall)
    stages, begin_s = graph.make_stages(), time.monotonic()
    summary = run_recorded(graph, stages, scratch, on_failure=errors.append, stall=stall)
    for error in errors:
        if not isinstance(error, StageError):
            raise error
    if summary.outcome == Outcome.STOPPED:
        return Result(task, {}, error=f"a process on {platform.node()} was told to stop")
    if task.draws and summary.frames:
        _draw(catalog, scratch)
    took_s = time.monotonic() - begin_s
    return replace(_result(task, scratch, summary.outcome), took_s=took_s, set_up_s=took_s - summary.wall_s)


def _result(task: Task, scratch: Path, outcome: str) -> Result:
    """Return the files of a finished run."""
    if not task.keeps_log:
        (scratch / RunFolder.LOG).unlink()
    made = [path for path in sorted(scratch.rglob("*")) if path.is_file()]
    files = {path.relative_to(scratch).as_posix(): path.read_bytes() for path in made}
    return Result(task, files, outcome=outcome)


def _draw(catalog: Catalog, scratch: Path) -> None:
    """Draw a run and its end; a picture that a plugin cannot draw costs no other."""
    errors = []
    try:
        with Recording(scratch / RunFolder.LOG) as recording:
            LogPictures(catalog, recording, scratch).draw()
    except DrawingError as error:
        errors.append(str(error))
    try:
        with Recording(scratch / RunFolder.LOG) as recording, drawing():
            catalog.hook.graphnav_draw_end(recording=recording, file=scratch / ENDING)
    except DrawingError as error:
        errors.append(str(error))
    if errors:
        (scratch / NOT_DRAWN).write_text("; ".join(dict.fromkeys(errors)), encoding="utf-8")


class _Study:
    """Cache of a study in this process from run to run: the catalog and every graph loaded so far."""

    def __init__(self, catalog: Catalog) -> None:
        self.catalog = catalog
        self._graphs: dict[tuple[str, str], Graph] = {}

    def graph(self, task: Task) -> Graph:
        """Return the graph of a run; that of a case is loaded once."""
        key = task.graph_yaml, task.graph_path
        if key not in self._graphs:
            self._graphs[key] = graph_of(task.graph_yaml.encode(), Path(task.graph_path), self.catalog)
        graph = self._graphs[key]
        return replace(graph, notices=task.notices, run=replace(graph.run, seed=task.seed, record=task.record))


@lru_cache(maxsize=1)
def _study(plugins: tuple[str, ...], wanted: tuple[tuple[str, str], ...]) -> _Study:
    """Return the study of a task; raises UserError where this process differs from what the study began with."""
    if other := difference_here(dict(wanted), plugins):
        raise UserError.of(
            f"{platform.node()} does not have what the study began with, but {other}",
            other.hint or "the runs would not compare: let all machines, from beginning to end, have the same",
        )
    catalog = Catalog()
    for plugin in plugins:
        catalog.add_file(Path(plugin))
    return _Study(catalog)
