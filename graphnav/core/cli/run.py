"""``graphnav run``: run a graph into a run folder."""

from __future__ import annotations

import json
import os
import sys
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphnav.core.api.parameters import Shared
from graphnav.core.cli.command_arguments import CommandArguments
from graphnav.core.cli.options import FailureReport, Options
from graphnav.core.cli.status import Exit
from graphnav.core.errors import DrawingError, shown_name
from graphnav.core.machine.system import require_linux
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, flag, seconds
from graphnav.core.rooms import in_room

if TYPE_CHECKING:
    from collections.abc import Mapping
    from contextlib import AbstractContextManager

    from graphnav.core.catalog import Catalog
    from graphnav.core.graph import Graph
    from graphnav.core.machine.console import Console
    from graphnav.core.runner.recording.full_log import FullLog
    from graphnav.core.runner.recording.run_recorded import LiveSink
    from graphnav.core.runner.recording.stall import StallLimit
    from graphnav.core.runner.recording.summary import Summary
    from graphnav.core.stage import Stage


@command(
    Shared.GRAPH,
    Shared.SET,
    Shared.PLUGINS,
    Shared.SEED,
    Shared.UNTIL_S,
    Options.PORTABLE,
    Shared.PACE,
    Shared.PROCESSES,
    Parameter(
        "host",
        "--host",
        metavar="NAME",
        help="be this host of the graph's 'deploy': wait for runs elsewhere that want its processes, until Ctrl-C",
    ),
    Options.HOSTS,
    Parameter(
        "key",
        "--key",
        type=Path,
        metavar="FILE",
        help="the key of this machine and of the hosts (default: that of 'graphnav tunnel'); with --host also '-': "
        "port and key come on standard input, from 'graphnav up', and its end ends the host",
    ),
    Shared.LIVE,
    Shared.LIVE_URL,
    Shared.FOLDER,
    Shared.TAP.but(default="thin"),
    Parameter("tap", "--no-tap", action="store_const", const="none", help="the same as --tap none"),
    Parameter(
        "stall_s",
        "--stall-s",
        type=seconds,
        metavar="S",
        help="end the run if one call into a stage takes longer than S seconds of wall time (default: never)",
    ),
    Shared.RECORD,
    flag("detach", "-d --detach", "return at once; see 'graphnav ps', 'logs' and 'stop'"),
    flag("video", "--video", "also draw video.mp4"),
    flag("no_pictures", "--no-pictures", "do not draw pictures; 'graphnav figure' can draw them later"),
    Options.JSON.but(help="print the summary as JSON instead of text"),
    Options.VERBOSE.but(help="print every metric, what each stage did, and the traceback of a failure"),
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.api.execute import require_processes

    if args.detach:
        require_linux("--detach works")
    catalog, graph = args.load_graph(runs=True)
    require_processes(graph, is_wanted=args.processes or args.host is not None)
    if args.host is not None:
        serve_host = in_room("processes.host_share").serve_host
        serve_host(graph, args.host, args.hosts, args.key, print_notice, partial(print, flush=True))
        return Exit.OK
    hosts = in_room("processes.hosts").hosts_of(graph, args.hosts, args.key) if graph.deploy else None
    return run_graph(args, catalog, graph, nullcontext(hosts))


def run_graph(
    args: CommandArguments,
    catalog: Catalog,
    graph: Graph,
    hosts: AbstractContextManager[Mapping[str, Any] | None],
) -> int:
    """Run a graph as the options say, within ``hosts``, which gives those that it names; return the exit status."""
    from graphnav.core.api.execute import runs_live
    from graphnav.core.lcm_url import tap_url
    from graphnav.core.machine.console import Console
    from graphnav.core.report.folder import make_run_folder, removed_if_empty
    from graphnav.core.report.summary_text import print_summary
    from graphnav.core.run_folder import RunFolder
    from graphnav.core.runner.recording.full_log import FullLog
    from graphnav.core.runner.recording.run_recorded import new_run_id
    from graphnav.core.tap import open_tap

    is_live = runs_live(graph, live=args.live, pace=args.pace, url=args.url, option="--")
    graph = graph.with_processes() if args.processes else graph
    live_notice = _live_notice(args, graph) if is_live else ""
    stages, run_id = graph.make_stages(), new_run_id()
    folder = make_run_folder(args.folder, graph.path.stem)
    if args.detach and _is_left_behind(folder, run_id):
        return Exit.OK
    console = Console(stderr=args.json, highlight=False, soft_wrap=True)
    with FullLog() as full, removed_if_empty(folder):
        for notice in (*args.notices_of(graph), *([live_notice] if is_live else [])):
            console.print(notice, markup=False)
        report, kept = FailureReport(args), None if args.no_pictures else full
        with hosts as found:
            tap = open_tap(args.tap, run_id, tell=partial(console.print, markup=False), notice=print_notice)
            if tap is not None:
                console.print(f"run {run_id} on {tap_url()}: watch it with 'graphnav spy'", markup=False)
            summary = _run(catalog, graph, stages, folder, args, tap, run_id, kept, report, found, is_live=is_live)
        if args.json:
            print(json.dumps(summary.as_json() | {"folder": str(folder)}))
        else:
            print_summary(console, summary, graph.metrics, is_verbose=args.verbose)
            if not args.verbose:
                console.print(
                    f"all metrics and the times of the stages: -v, or {RunFolder.SUMMARY}", style="dim", markup=False
                )
        if summary.failure:
            report.print(summary.failure)
        files = _draw(args, catalog, summary, folder, full)
    console.print(_listing(folder, files, console.width if console.is_terminal else None), markup=False)
    return {"failed": Exit.FAILED, "stopped": Exit.INTERRUPTED}.get(summary.outcome, Exit.OK)


def _is_left_behind(folder: Path, run_id: str) -> bool:
    """Go on in another process, whose output goes into a file of the folder; return whether this is the one before.

    The one before waits until the run can be listed. No thread and no connection exists yet.
    """
    from graphnav.core.run_folder import RunFolder
    from graphnav.core.runner import RunningRun

    printed = os.open(folder / RunFolder.PRINTED, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
    if pid := os.fork():
        RunningRun.await_begin(run_id, pid)
        print(f"run {run_id} in {shown_name(str(folder))}\n  graphnav logs -f {run_id}\n  graphnav stop {run_id}")
        return True
    os.setsid()
    nothing = os.open(os.devnull, os.O_RDONLY)
    for fd, end in ((nothing, 0), (printed, 1), (printed, 2)):
        os.dup2(fd, end)
    return False


def _draw(args: CommandArguments, catalog: Catalog, summary: Summary, folder: Path, full: FullLog) -> list[str]:
    """Draw the pictures of a run; return the files of its folder as they are listed, logs with their sizes."""
    from graphnav.core.record.log_paths import parts_of
    from graphnav.core.report.pictures import LogPictures
    from graphnav.core.run_folder import RunFolder
    from graphnav.core.runner.recording.log_forecast import size_text

    files, pictures = [RunFolder.LOG, RunFolder.GRAPH, RunFolder.SUMMARY], list[str]()
    wants_pictures = bool(summary.frames) and not args.no_pictures
    if summary.outcome == "stopped" and wants_pictures:
        print(f"no pictures were drawn; to draw them, run: graphnav figure {folder}", file=sys.stderr)
    elif wants_pictures:
        try:
            with full.recording(folder / RunFolder.LOG, print_notice) as recording:
                pictures = [path.name for path in LogPictures(catalog, recording, folder).draw(video=args.video)]
        except DrawingError as error:
            report = FailureReport(args)
            report(error)
            report.print(f"not drawn: {error}")
            files += [path.name for path in parts_of(folder / RunFolder.LOG)]
            pictures = sorted(p.name for p in folder.iterdir() if p.is_file() and p.name not in files)
        except KeyboardInterrupt:
            print(f"some pictures were not drawn; to draw them, run: graphnav figure {folder}", file=sys.stderr)
            raise
    logs = [f"{path.name} ({size_text(path.stat().st_size)})" for path in parts_of(folder / RunFolder.LOG)]
    return [*logs, RunFolder.GRAPH, RunFolder.SUMMARY, *pictures]


def _listing(folder: Path, files: list[str], width: int | None) -> str:
    """Return the folder with its files, on two lines where one is too long for ``width``."""
    name = shown_name(str(folder))
    line = f"{name}: {', '.join(files)}"
    return line if width is None or len(line) <= width else f"{name}:\n  {', '.join(files)}"


def _live_notice(args: CommandArguments, graph: Graph) -> str:
    from graphnav.core.lcm_url import live_url

    devices = [node.name for node in graph.nodes if node.is_live_source]
    parts = (("inputs", graph.inputs), ("from a device", devices))
    why = "--live" if args.live else "; ".join(f"{what}: {', '.join(names)}" for what, names in parts if names)
    return f"live on {live_url(graph, args.url)} ({why}); Ctrl-C ends it"


def _run(
    catalog: Catalog,
    graph: Graph,
    stages: dict[str, Stage],
    folder: Path,
    args: CommandArguments,
    tap: LiveSink | None,
    run_id: str,
    full: FullLog | None,
    report: FailureReport,
    hosts: Mapping[str, Any] | None,
    *,
    is_live: bool,
) -> Summary:
    from graphnav.core.api.execute import execute
    from graphnav.core.cli.progress import progress_bar
    from graphnav.core.machine.console import Console
    from graphnav.core.runner.recording.changes import Changes
    from graphnav.core.runner.recording.running_file import RunningFile

    bar = Console(stderr=True)

    with (
        Changes(run_id, graph, catalog) as changes,
        progress_bar(bar, graph.path.stem, graph.run.until_s) as on_tick,
        RunningFile(run_id, graph.path.stem, folder, is_live=is_live, takes_changes=changes.is_listening),
    ):
        return execute(
            graph,
            stages,
            folder,
            is_live=is_live,
            pace=args.pace,
            url=args.url,
            tap=tap,
            run_id=run_id,
            on_time=lambda run_s: on_tick(round(run_s * 1e6)),
            on_failure=report,
            notice=print_notice,
            stall=_stall_limit(args, folder, bar),
            full=full,
            changes=changes,
            hosts=hosts,
        )


def _stall_limit(args: CommandArguments, folder: Path, bar: Console) -> StallLimit | None:
    """Return the limit of a call into a stage, as the user gives it."""
    from graphnav.core.runner.recording.stall import StallLimit

    def tell_stalled(summary: Summary) -> None:
        bar.show_cursor()
        if args.json:
            print(json.dumps(summary.as_json() | {"folder": str(folder)}))
        print(f"{summary.failure}\n  the log up to there and summary.json are in {folder}", file=sys.stderr)
        sys.stdout.flush()
        sys.stderr.flush()

    return None if args.stall_s is None else StallLimit(args.stall_s, tell_stalled)
