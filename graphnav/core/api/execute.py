"""Run a checked graph into a folder, in lockstep or live, for ``graphnav run`` and `graphnav.run`."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from graphnav.core.errors import GraphnavError, UserError
from graphnav.core.graph import Graph
from graphnav.core.machine.system import require_linux
from graphnav.core.rooms import in_room
from graphnav.core.runner.recording.changes import Changes
from graphnav.core.runner.recording.full_log import FullLog
from graphnav.core.runner.recording.run_recorded import LiveSink, run_recorded
from graphnav.core.runner.recording.stall import StallLimit
from graphnav.core.runner.recording.summary import Summary
from graphnav.core.stage import Stage

MAX_PACE = 1e6
"""The maximum of the pace, which no machine could keep; the inverse is the minimum, at which a tick takes a day."""


def runs_live(graph: Graph, *, live: bool, pace: float | None, url: str | None, option: str = "") -> bool:
    """Return whether a run is live.

    ``option``: prefix of option names in errors: ``--`` on the command line.

    Raises
    ------
    UserError
        An option has no effect on such a run, the pace is out of bounds, or this system makes no such runs.
    """
    if pace is not None and not 1 / MAX_PACE <= pace <= MAX_PACE:
        wanted = f"from {1 / MAX_PACE:g} to {MAX_PACE:g}" if 0 < pace < math.inf else "above 0"
        raise UserError.of(f"{option}pace is {pace:g}, but must be {wanted}", "remove it to run as fast as possible")
    is_live = live or graph.is_live
    if is_live and pace is not None:
        what = f"{option}pace has no effect on a live run, which runs in wall time"
        raise UserError.of(what, f"remove {option}pace")
    if not is_live and url is not None:
        what = f"{option}url is for live runs, but this graph runs in lockstep"
        raise UserError.of(what, f"add {option}live{'' if option else '=True'}, or remove {option}url")
    if is_live:
        require_linux("live runs work")
    require_processes(graph)
    return is_live


def require_processes(graph: Graph, *, is_wanted: bool = False) -> None:
    """Raise UserError if a graph, or its user, wants several processes on a system other than Linux."""
    if graph.deploy or is_wanted:
        require_linux("runs in several processes work")


def _run_live(graph: Graph, *given: Any, **options: Any) -> Summary:
    run: Callable[..., Summary] = in_room("live.run").run_live
    if graph.deploy:
        run = partial(in_room("processes.run").run_live_processes, run)
    return run(graph, *given, **options)


def execute(
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    *,
    is_live: bool,
    pace: float | None,
    url: str | None,
    tap: LiveSink | None,
    run_id: str,
    on_time: Callable[[float], None],
    on_failure: Callable[[GraphnavError], None],
    notice: Callable[[str], None],
    stall: StallLimit | None = None,
    full: FullLog | None = None,
    changes: Changes | None = None,
    hosts: Mapping[str, Any] | None = None,
) -> Summary:
    """Run a graph into an existing, empty folder; see `run_recorded`, and ``run_live`` and ``run_processes`` of rooms.

    ``on_time`` gets seconds: the simulated time of the next tick; in a live run the time since the start, now and then.
    ``full`` gets every message of a lockstep run. ``changes`` may change the stages while it lasts.
    ``hosts``: where the hosts of its processes are, None for as ``hosts.yaml`` says.
    """
    options: dict[str, Any] = {
        "tap": tap,
        "run_id": run_id,
        "on_failure": on_failure,
        "notice": notice,
        "stall": stall,
        "changes": changes,
    }
    if graph.deploy:
        options["hosts"] = hosts
    if is_live:
        return _run_live(graph, stages, folder, url=url, on_time=on_time, **options)
    run: Callable[..., Summary] = in_room("processes.run").run_processes if graph.deploy else run_recorded
    options |= {"pace_ratio": pace, "on_tick": lambda utime: on_time(utime / 1e6), "full": full}
    return run(graph, stages, folder, **options)
