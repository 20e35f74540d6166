"""Execute the runs of a study in the terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from graphnav import UserError
from graphnav.core.machine import Console
from graphnav.studies.ablation.execution import TimeEstimate
from graphnav.studies.ablation.plan import Job
from graphnav.studies.api.study_run import StudyRun
from graphnav.studies.commands.study_progress import study_bar

FEW_RUNS = 100
"""So many runs and fewer begin without an estimate of their time."""
MANY_RUNS = 1000
"""More runs than this need a confirmation."""
WORTH_TELLING_S = 10.0
"""Less time than this is not told."""


class StudyConsole:
    """A person at a console: sees the runs made, and is asked before many."""

    def __init__(self, console: Console, *, is_sure: bool) -> None:
        self._console, self._is_sure = console, is_sure
        self._errors = Console(stderr=True, highlight=False, soft_wrap=True)

    def accept(self, run: StudyRun) -> Sequence[Job] | None:
        """Return the pending runs, None where the user does not want them.

        Raises
        ------
        UserError
            They are many, and this is not a terminal to ask at.
        """
        jobs, total = run.pending(), run.plan.n_jobs
        if len(jobs) < total:
            self._console.print(f"{total - len(jobs)} of {total} runs are finished already", markup=False)
        if len(jobs) <= MANY_RUNS or self._is_sure:
            if len(jobs) > FEW_RUNS:
                self._console.print(_estimate_text(run.estimate(jobs), run.workers.at_once), markup=False)
            return jobs
        if not (sys.stdin.isatty() and self._console.is_terminal):
            what = f"{len(jobs)} runs are pending, and cannot ask for confirmation: not a terminal"
            raise UserError.of(what, "add --yes, or use fewer seeds")
        if len(jobs) == total:
            self._console.print("executing one run first, to measure its time")
            run.make(jobs[:1])
            jobs = jobs[1:]
        if not _wants(len(jobs), run.seconds_a_run() / run.workers.at_once, self._console):
            self._console.print("no more runs; --seeds and --vary make the study smaller")
            return None
        return jobs

    @contextmanager
    def progress(
        self, title: str, done: int, total: int, left_s: Callable[[], float | None] | None = None
    ) -> Iterator[Callable[[str], None]]:
        """Show the progress bar, and say once how long the runs take, as soon as each graph has some that are made."""
        with study_bar(self._errors, title, done, total, left_s) as show:
            made, is_told = done, left_s is None

            def on_made(outcome: str) -> None:
                nonlocal made, is_told
                show(outcome)
                made += 1
                if not is_told and left_s is not None and (left := left_s()) is not None:
                    is_told = True
                    if left >= WORTH_TELLING_S:
                        self._errors.print(f"{total - made} runs left, about {duration_text(left)}", markup=False)

            yield on_made

    def failed(self, text: str) -> None:
        """Print a failed run above the progress bar."""
        self._errors.print(text, markup=False, style="red")

    def tell(self, line: str) -> None:
        """Print a line."""
        self._console.print(line, markup=False)


def _estimate_text(found: TimeEstimate, at_once: int) -> str:
    """Return the core-hours of runs, about, and what they suppose."""
    begin = f"{found.n_runs} runs, {at_once} at once"
    if found.n_unknown == found.n_runs:
        return f"{begin}; {_unknown_text(found)}"
    unknown = f", without {found.n_unknown} runs of which none is known" if found.n_unknown else ""
    hours = f"about {found.core_s / 3600:.2g} core-hours ({duration_text(found.core_s / at_once)})"
    return f"{begin}: {hours} if each lasts until its time limit and costs what the first does{unknown}"


def _unknown_text(found: TimeEstimate) -> str:
    """Return why the time of no run is known."""
    if found.n_unlimited == found.n_runs:
        return "they have no time limit"
    what = "how long they take is not known"
    if not found.n_unlimited:
        return f"{what}, because the run that measures it failed"
    have = "has" if found.n_unlimited == 1 else "have"
    return f"{what}: {found.n_unlimited} of them {have} no time limit, and the run that measures the others failed"


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
