"""``graphnav.run``: run a graph from Python."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import get_args

from graphnav.api.arguments import PathLike, plain, wrong_type
from graphnav.api.execute import execute, runs_live
from graphnav.api.finished_run import Run
from graphnav.api.load import add_plugins, loaded, with_run_options
from graphnav.api.notices import tell
from graphnav.api.one_thread import one_thread
from graphnav.api.open_tap import TapMode, open_tap
from graphnav.api.result_folder import new_folder
from graphnav.catalog import Catalog
from graphnav.errors import GraphnavError
from graphnav.graph import Graph
from graphnav.live import live_url
from graphnav.record import LOG
from graphnav.report.pictures import draw_pictures
from graphnav.runner import Outcome
from graphnav.runner.recording.run_recorded import new_run_id

_drawing = threading.Lock()
"""Matplotlib's settings are global: runs in several threads draw one after another."""


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
    live: bool = False,
    url: str | None = None,
    pictures: bool = True,
    check: bool = False,
) -> Run:
    """Run a graph to its end and return the results.

    A run that fails does not raise: its outcome is ``"failed"``, `Run.failure` says why, and its log is complete
    up to there. ``check=True``, or `Run.check` later, raises `RunError`, as with `subprocess.run`. The same seed gives
    the same log, byte for byte, as ``graphnav run`` does.

    Works in notebooks, in threads and several times in a process. Notices (lateness, pictures that could not be drawn)
    go to the logger ``graphnav``.

    Parameters
    ----------
    graph, set, plugins
        As for `graphnav.load`, or a graph that it returned.
    seed
        Seed of all randomness, instead of the graph's.
    until_s
        End of the run, instead of the graph's: simulated seconds; in a live run, seconds since the start.
    folder
        The run folder, new or empty. None: a temporary one, removed when neither the `Run` nor its log is in
        use any longer.
    pace
        Simulated seconds per second of wall time; None: as fast as the machine allows.
    tap
        Copies for ``graphnav spy`` and other viewers: ``"thin"``, ``"full"``, ``"none"``.
    live
        Run in wall time, on channels of other programs; implied by a graph with inputs.
    url
        LCM URL of live inputs and outputs.
    pictures
        Draw the panels and the map from the log.
    check
        Raise `RunError` if the run fails.

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
    catalog = Catalog()
    checked = with_run_options(loaded(graph, set, plugins, catalog), {"seed": seed, "until_s": until_s})
    _check_arguments(pace, tap, url)
    is_live = runs_live(checked, live=live, pace=pace, url=url)
    if is_live:
        live_url(checked, url, "url")
    stages = checked.make_stages()
    kept = new_folder(folder)
    errors: list[GraphnavError] = []
    run_id = new_run_id()
    with one_thread():
        summary = execute(
            checked,
            stages,
            kept.path,
            is_live=is_live,
            pace=pace,
            url=url,
            tap=open_tap(tap, run_id, tell=tell),
            run_id=run_id,
            on_time=lambda _: None,
            on_failure=errors.append,
            notice=tell,
        )
    if summary.outcome == Outcome.STOPPED and not is_live:
        raise KeyboardInterrupt
    if summary.failure and not check:
        tell(f"the run failed: {summary.failure}")
    drawn = _draw(catalog, checked, kept.path) if pictures and summary.frames else ()
    result = Run(checked, summary, kept, drawn, errors[0] if errors else None)
    return result.check() if check else result


def _check_arguments(pace: object, tap: object, url: object) -> None:
    """Raise UserError for arguments of a wrong type."""
    if pace is not None and (isinstance(pace, bool) or not isinstance(plain(pace, "pace"), int | float)):
        raise wrong_type("pace", pace, "a number or None", "write pace=1 for wall time")
    if tap not in get_args(TapMode):
        raise wrong_type("tap", tap, '"thin", "full" or "none"', 'write tap="thin" to watch with graphnav spy')
    if url is not None and not isinstance(url, str):
        raise wrong_type("url", url, "a string or None", 'write url="udpm://239.255.76.67:7667?ttl=0"')


def _draw(catalog: Catalog, graph: Graph, folder: Path) -> Sequence[Path]:
    """Return the pictures of a run; log those that cannot be drawn as notices."""
    try:
        with _drawing:
            return draw_pictures(add_plugins(catalog, graph.plugins), folder / LOG, folder, video=False)
    except GraphnavError as error:
        tell(f"not drawn: {error}")
        return sorted(folder.glob("*.png"))
