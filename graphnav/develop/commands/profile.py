"""``graphnav profile``: where the time of a tick goes."""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import UserError
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, FailureReport, Options
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command, flag
from graphnav.develop.parameters import CLOCK, percent

if TYPE_CHECKING:
    from graphnav import Graph, Stage
    from graphnav.develop.profiling import Profile


@command(
    *Shared.LOADED,
    Shared.SEED,
    Shared.UNTIL_S,
    Options.PORTABLE,
    Shared.TAP.but(help="also measure copies for viewers on this machine (default: %(default)s)"),
    CLOCK,
    Parameter(
        "flame",
        "--flame",
        type=Path,
        metavar="FILE.svg",
        help="draw a flame graph; with pyinstrument installed also of the functions inside of the steps",
    ),
    flag("fit", "--fit", "also run with larger and larger pictures: which size fits the graph's rate"),
    Parameter(
        "budget",
        "--budget",
        type=percent,
        metavar="PERCENT",
        help="as --fit, on so many percent of one core: what fits on a smaller computer; a quota of Linux",
    ),
    Shared.FOLDER.but(help="keep the run folder, new or empty (default: temporary)"),
    flag("sort", "--sort", "stages and channels that take longest first (default: in firing order)"),
    Options.JSON,
    Options.VERBOSE,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    from graphnav.core.machine import Console
    from graphnav.develop.profiling import (
        NothingMeasuredError,
        functions_missing,
        measure_fit,
        print_profile,
        refuse_live,
    )

    _, graph = args.load_graph()
    refuse_live(graph)
    if args.flame is not None:
        _check_file(args.flame)
    if args.budget is not None:
        _check_budget(args)
    stages = graph.make_stages()
    for notice in args.notices_of(graph):
        print_notice(notice)
    if args.flame is not None and (missing := functions_missing()):
        print_notice(str(missing))
    report = FailureReport(args)
    try:
        with _folder(args.folder, graph) as folder:
            profile = _measure(args, graph, stages, folder, report)
        wants_fit = (args.fit or args.budget is not None) and not profile.failure and profile.outcome != "stopped"
        fit = measure_fit(graph, profile.rate_hz, args.clock, args.budget, print_notice) if wants_fit else None
    except NothingMeasuredError as error:
        report.print(str(error))
        return Exit.INTERRUPTED if error.outcome == "stopped" else Exit.FAILED
    if args.json:
        print(json.dumps(profile.as_json() | ({} if fit is None else {"fit": asdict(fit)})))
    else:
        print_profile(Console(highlight=False, soft_wrap=True), profile, slowest_first=args.sort)
        if fit is not None:
            print(fit)
    if args.flame is not None:
        _write(args.flame, profile)
    if profile.failure:
        report.print(profile.failure)
    if profile.outcome == "stopped":
        print("stopped; these are the times up to there", file=sys.stderr)
    return {"failed": Exit.FAILED, "stopped": Exit.INTERRUPTED}.get(profile.outcome, Exit.OK)


def _measure(
    args: CommandArguments, graph: Graph, stages: dict[str, Stage], folder: Path, report: FailureReport
) -> Profile:
    from graphnav.core.cli import progress_bar
    from graphnav.core.machine import Console
    from graphnav.core.runner import new_run_id
    from graphnav.core.tap import open_tap
    from graphnav.develop.profiling import functions_missing, measure

    run_id = new_run_id()
    with progress_bar(Console(stderr=True), graph.path.stem, graph.run.until_s) as on_tick:
        return measure(
            graph,
            stages,
            folder,
            functions=args.flame is not None and not functions_missing(),
            clock=args.clock,
            tap=open_tap(args.tap, run_id, tell=print_notice),
            run_id=run_id,
            on_tick=on_tick,
            on_failure=report,
            notice=print_notice,
        )


@contextmanager
def _folder(wanted: Path | None, graph: Graph) -> Iterator[Path]:
    """Yield the folder of the run, by default a temporary one."""
    from graphnav.core.report import make_run_folder, removed_if_empty

    if wanted is None:
        with tempfile.TemporaryDirectory(prefix="graphnav-") as scratch:
            yield Path(scratch)
        return
    folder = make_run_folder(wanted, graph.path.stem)
    with removed_if_empty(folder):
        yield folder


def _check_budget(args: CommandArguments) -> None:
    """Refuse a share of a core that cannot be measured, before the run."""
    from graphnav.core.machine import CpuQuota

    if args.clock != "wall":
        raise UserError.of("--budget is measured by wall time", "leave out --clock cpu")
    with CpuQuota(args.budget):
        pass


def _check_file(path: Path) -> None:
    """Refuse a file that cannot be written, before the run."""
    folder = path.parent
    if path.is_dir():
        why = "it is a folder"
    elif not folder.is_dir():
        why = f"there is no folder {folder}"
    elif not os.access(path if path.exists() else folder, os.W_OK):
        why = "permission denied"
    else:
        return
    raise UserError.of(f"--flame: cannot write {path}: {why}", "choose another file with --flame")


def _write(path: Path, profile: Profile) -> None:
    try:
        path.write_text(profile.flame, encoding="utf-8")
    except OSError as error:
        what = f"--flame: cannot write {path}: {error.strerror}"
        raise UserError.of(what, "choose another file with --flame") from error
    print(f"wrote {path}", file=sys.stderr)
