"""``graphnav.run``: run a graph from Python."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from graphnav.core.api.arguments import Argument, PathLike
from graphnav.core.api.blas_threads import one_thread
from graphnav.core.api.execute import execute, runs_live
from graphnav.core.api.finished_run import Run
from graphnav.core.api.load import loaded
from graphnav.core.api.notices import tell
from graphnav.core.api.parameters import Shared, TapMode
from graphnav.core.api.result_folder import KeptFolder
from graphnav.core.catalog import Catalog
from graphnav.core.errors import GraphnavError
from graphnav.core.graph import Graph
from graphnav.core.lcm_url import live_url
from graphnav.core.parameters import documented
from graphnav.core.report.pictures import LogPictures
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome
from graphnav.core.runner.recording.full_log import FullLog
from graphnav.core.runner.recording.run_recorded import new_run_id
from graphnav.core.runner.recording.running_file import RunningFile
from graphnav.core.spec import RecordOption
from graphnav.core.tap import open_tap
from graphnav.core.trust import Trust

_drawing = threading.Lock()
"""Matplotlib's settings are global: runs in several threads draw one after another."""


@documented(*Shared.OF_RUN)
def run(
    graph: PathLike | Graph,
    *,
    set: Mapping[str, object] | None = None,  # noqa: A002 - as --set
    seed: int | None = None,
    until_s: float | None = None,
    folder: PathLike | None = None,
    plugins: Sequence[PathLike] = (),
    pace: float | None = None,
    tap: TapMode = "none",
    processes: bool = False,
    live: bool = False,
    url: str | None = None,
    record: RecordOption | None = None,
    pictures: bool = True,
    check: bool = False,
) -> Run:
    """Run a graph to its end and return the results.

    A run that fails does not raise: its outcome is ``"failed"``, `Run.failure` says why, and its log is complete
    up to there. ``check=True``, or `Run.check` later, raises `RunError`, as with `subprocess.run`. The same seed gives
    the same log, byte for byte, as ``graphnav run`` does.

    Works in notebooks, in threads and several times in a process. Notices (lateness, pictures that could not be drawn)
    go to the logger ``graphnav``.

    Raises
    ------
    UserError
        All errors of the graph and the arguments; nothing has run then.
    RunError
        The run failed, and ``check`` is true.
    KeyboardInterrupt
        Ctrl-C, or a notebook's stop button, ended a lockstep run; its folder is complete up to there. A live run
        without ``until_s`` ends this way, and is returned.
    GraphnavError
        A file cannot be written.
    """
    Argument(pace, Shared.PACE).check_number()
    Argument(tap, Shared.TAP).check_choice()
    Argument(url, Shared.LIVE_URL).check_text()
    catalog = Catalog(Trust(runs_all=True))
    checked = loaded(graph, set, plugins, catalog, {"seed": seed, "until_s": until_s, "record": record})
    result = _run(checked, catalog, folder, _Mode(live, processes, pace, url, tap), draws=pictures)
    if result.failure and not check:
        tell(f"the run failed: {result.failure}")
    return result.check() if check else result


@dataclass(frozen=True)
class _Mode:
    """By which clock a graph runs, and what leaves it."""

    live: bool
    processes: bool
    pace: float | None
    url: str | None
    tap: TapMode


def _run(graph: Graph, catalog: Catalog, folder: PathLike | None, mode: _Mode, *, draws: bool) -> Run:
    """Run a graph into a folder and draw it; raise KeyboardInterrupt where Ctrl-C ended a lockstep run."""
    is_live = runs_live(graph, live=mode.live, pace=mode.pace, url=mode.url)
    graph = graph.with_processes() if mode.processes else graph
    if is_live:
        live_url(graph, mode.url, "url")
    stages = graph.make_stages()
    kept = KeptFolder.new(folder)
    errors: list[GraphnavError] = []
    run_id = new_run_id()
    with FullLog() as full:
        with one_thread(), RunningFile(run_id, graph.path.stem, kept.path, is_live=is_live):
            summary = execute(
                graph,
                stages,
                kept.path,
                is_live=is_live,
                pace=mode.pace,
                url=mode.url,
                tap=open_tap(mode.tap, run_id, tell=tell),
                run_id=run_id,
                on_time=lambda _: None,
                on_failure=errors.append,
                notice=tell,
                full=full if draws else None,
            )
        if summary.outcome == Outcome.STOPPED and not is_live:
            raise KeyboardInterrupt
        drawn = _draw(catalog, graph, kept.path, full) if draws and summary.frames else ()
    return Run(graph, summary, kept, drawn, errors[0] if errors else None)


def _draw(catalog: Catalog, graph: Graph, folder: Path, full: FullLog) -> Sequence[Path]:
    """Return the pictures of a run; log those that cannot be drawn as notices."""
    try:
        with _drawing, full.recording(folder / RunFolder.LOG, tell) as recording:
            return LogPictures(catalog.add_files(graph.plugins), recording, folder).draw()
    except GraphnavError as error:
        tell(f"not drawn: {error}")
        return sorted(folder.glob("*.png"))
