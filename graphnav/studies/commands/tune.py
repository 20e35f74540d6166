"""``graphnav tune``: give every rival the same budget to find its parameters."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Problem, UserError
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options, counted
from graphnav.core.interrupts import ended_by_interrupt
from graphnav.core.parameters import command
from graphnav.studies.parameters import (
    CLUSTER,
    FOLDER,
    JOBS,
    METRICS,
    SAMPLER_SEED,
    SEARCH,
    SEEDS,
    STUDY,
    TRIALS,
    VARY,
    YES,
)

if TYPE_CHECKING:
    from graphnav.core.machine import Console
    from graphnav.studies.tuning import Tuning, TuningRequest, TuningRun

_ABOUT = """\
Every rival gets the same number of trials in the same worlds; its first trial is the rival as it is. Seeds from 1000 on
are refused: they are for reporting. The folder keeps every run: the same command resumes a tuning that was interrupted.
"""
_MANY_RUNS = 1000


@command(
    Options.PORTABLE,
    STUDY.but(
        nargs="+",
        metavar="GRAPH",
        help="graphs, or a study with one axis: files or names of shipped ones",
        offers="graphs",
    ),
    VARY.but(help="the rivals, as of graphnav ablate (plane=plane.ica,plane.affine)"),
    TRIALS,
    SEEDS.but(help="seeds of the worlds, below 1000, END excluded, or 1,2,5"),
    METRICS.but(help="what is tuned for; equal trials are told apart by the next one"),
    SEARCH,
    Shared.SET,
    Shared.PLUGINS,
    SAMPLER_SEED,
    FOLDER.but(help="the folder (default: tunings/GRAPH)"),
    JOBS,
    CLUSTER.but(help="run on the Dask cluster whose scheduler is at tcp://host:8786"),
    YES,
    about=_ABOUT,
)
def main(args: CommandArguments) -> int:
    """Run the command."""
    with ended_by_interrupt(owns_process=args.owns_process):
        from graphnav.core.machine import Console
        from graphnav.studies.api.tune import tune_into
        from graphnav.studies.commands.study_progress import study_bar
        from graphnav.studies.tuning import check_tuning, named_after

        tuning = check_tuning(_request(args), args.catalog(runs_all=True), shlex.join(["graphnav", *args.words]))
    console = Console(highlight=False, soft_wrap=True)
    folder = args.folder or Path("tunings") / named_after(args.study)
    _print_search(tuning, console)
    if tuning.n_runs > _MANY_RUNS and not args.yes and not _confirmed(tuning.n_runs, console):
        return Exit.OK
    try:
        with study_bar(Console(stderr=True), "tune", 0, tuning.n_runs) as show:

            def on_made(n_runs: int) -> None:
                for _ in range(n_runs):
                    show("made")

            run = tune_into(tuning, folder, args.jobs, args.cluster, on_made)
    except KeyboardInterrupt:
        print("stopped: every finished run is kept; resume with the same command", file=sys.stderr)
        return Exit.INTERRUPTED
    _print_result(run, folder, console)
    return Exit.FAILED if run.has_failed() else Exit.OK


def _request(args: CommandArguments) -> TuningRequest:
    """Return the tuning that the command line asks for."""
    from graphnav.core.graph import Override
    from graphnav.studies.ablation.study import parse_varies
    from graphnav.studies.tuning import TuningRequest, parse_searches

    problems: list[Problem] = []
    return TuningRequest(
        names=args.study,
        varies=parse_varies(args.vary, problems),
        overrides=Override.parse_all(args.set, problems),
        seeds=args.seeds,
        metrics=args.metrics,
        searches=parse_searches(args.search, problems),
        trials=args.trials,
        sampler_seed=args.sampler_seed,
        plugins=args.plugins,
        problems=problems,
    )


def _print_search(tuning: Tuning, console: Console) -> None:
    """Print what is searched of each rival, before anything runs."""
    for rival in tuning.rivals:
        found = [searched.text for searched in rival.space]
        console.print(
            f"{rival.label}: {counted(tuning.n_trials(rival), 'trial')} of {', '.join(found) or 'nothing'}",
            markup=False,
        )
        if rival.left:
            left = ", ".join(rival.left)
            console.print(f"  not searched, because nothing says what they could be: {left}", markup=False)
    runs = f"{counted(tuning.n_runs, 'run')}, {tuning.runs_per_trial} of each trial"
    console.print(f"{runs}, on {', '.join(tuning.study.graphs)}", markup=False)


def _print_result(run: TuningRun, folder: Path, console: Console) -> None:
    from graphnav.core.tables import print_fitted
    from graphnav.studies.tuning import (
        OPTIMISTIC,
        STUDY,
        TABLE,
        TRIALS,
        conclusion,
        params_text,
        trouble_texts,
        tuned_table,
    )

    print_fitted(console, tuned_table(run, has_params=False), is_framed=False)
    for rival in run.ranking(tuned=True):
        console.print(f"{rival.label}: {params_text(run.best(rival))}", markup=False)
    console.print(conclusion(run), markup=False)
    for text in trouble_texts(run):
        console.print(text, markup=False)
    console.print(OPTIMISTIC, markup=False)
    console.print(f"{folder}: {TABLE}, {TRIALS}, {STUDY}", markup=False)
    plugins = [word for path in run.tuning.request.plugins for word in ("--plugin", str(path))]
    console.print(
        shlex.join(["graphnav", "ablate", str(folder / STUDY), *plugins, "--seeds", "1000:1020"]), markup=False
    )


def _confirmed(n_runs: int, console: Console) -> bool:
    """Ask for confirmation of many runs.

    Raises
    ------
    UserError
        This is not a terminal to ask at.
    """
    if not (sys.stdin.isatty() and console.is_terminal):
        what = f"{n_runs} runs are pending, and cannot ask for confirmation: not a terminal"
        raise UserError.of(what, "add --yes, or use fewer trials or seeds")
    try:
        return console.input("Continue? [y/N] ", markup=False).strip().lower() in {"y", "yes"}
    except EOFError:
        return False
