"""Execute the runs of a study in the terminal."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console

from graphnav.ablation.execution import (
    StudyFolder,
    TaskFactory,
    Workers,
    draw_failures,
    execute,
    pending_drawings,
    pending_jobs,
)
from graphnav.ablation.plan import Plan
from graphnav.ablation.results import read_records, worst_failures
from graphnav.api.studies.ablate import study_workers
from graphnav.cli.study_progress import study_bar
from graphnav.errors import UserError

MANY_RUNS = 1000
"""More runs than this need a confirmation."""


@contextmanager
def workers_of(cluster: str | None, jobs: int | None, folder: StudyFolder) -> Iterator[Workers]:
    """Provide workers: a cluster, or ``jobs`` processes (default: one per core); SIGTERM stops them like Ctrl-C."""
    old = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with study_workers(cluster, jobs, folder.scratch) as workers:
            yield workers
    finally:
        signal.signal(signal.SIGTERM, old)


def make_missing(
    plan: Plan, tasks: TaskFactory, folder: StudyFolder, workers: Workers, console: Console, *, is_sure: bool
) -> bool:
    """Execute the pending runs; return whether all are finished, False if the user declines.

    Raises
    ------
    UserError
        They need a confirmation, and there is no terminal to ask for it.
    """
    jobs = pending_jobs(plan, folder)
    if len(jobs) < plan.n_jobs:
        console.print(f"{plan.n_jobs - len(jobs)} of {plan.n_jobs} runs are finished already", markup=False)
    if len(jobs) > MANY_RUNS and not is_sure:
        if not (sys.stdin.isatty() and console.is_terminal):
            what = f"{len(jobs)} runs are pending, and cannot ask for confirmation: not a terminal"
            raise UserError.of(what, "add --yes, or use fewer seeds")
        if len(jobs) == plan.n_jobs:
            console.print("executing one run first, to measure its time")
            execute(jobs[:1], tasks, folder, workers)
            jobs = jobs[1:]
        if not _wants(len(jobs), _seconds_a_run(plan, folder) / workers.at_once, console):
            console.print("no more runs; --seeds and --vary make the study smaller")
            return False
    with study_bar(Console(stderr=True), plan.name, plan.n_jobs - len(jobs), plan.n_jobs) as on_made:
        execute(jobs, tasks, folder, workers, on_made)
    return True


def draw_worst(
    plan: Plan,
    tasks: TaskFactory,
    folder: StudyFolder,
    workers: Workers,
    console: Console,
    *,
    each: int,
    keep_logs: bool,
) -> None:
    """Draw the worst failures that are not drawn; report those that do not recur or cannot be drawn."""
    chosen = worst_failures(plan, read_records(plan, folder.path), each)
    jobs = pending_drawings(chosen, folder, keep_logs=keep_logs)
    with study_bar(Console(stderr=True), "failures", len(chosen) - len(jobs), len(chosen)) as on_made:
        for line in draw_failures(jobs, tasks, folder, workers, on_made, keep_logs=keep_logs):
            console.print(line, markup=False)


def _wants(n_jobs: int, seconds_each: float, console: Console) -> bool:
    """Ask for confirmation of many runs."""
    question = f"{n_jobs} runs are pending, about {duration_text(n_jobs * seconds_each)}. Continue? [y/N] "
    try:
        return console.input(question, markup=False).strip().lower() in {"y", "yes"}
    except EOFError:
        return False


def duration_text(seconds: float) -> str:
    """Return a duration in words."""
    for unit, size in (("days", 86400), ("hours", 3600), ("minutes", 60)):
        if seconds >= 2 * size:
            return f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 1):.0f} seconds"


def _seconds_a_run(plan: Plan, folder: StudyFolder) -> float:
    walls = [record.wall_s for record in read_records(plan, folder.path)]
    return sum(walls) / len(walls)
