"""Execute the runs of a study in the terminal."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from graphnav import UserError
from graphnav.core.machine import Console
from graphnav.studies.ablation.execution import TimeEstimate
from graphnav.studies.ablation.plan import Job
from graphnav.studies.api.study_run import WORTH_TELLING_S, StudyRun
from graphnav.studies.commands.study_progress import study_bar

MANY_RUNS = 1000
"""More runs than this need a confirmation."""
LATER = 0.5
"""So much more than the time left that was told last may it take until it is told once more."""


class StudyConsole:
    """A person at a console: sees the runs made, and is asked before many."""

    def __init__(self, console: Console, *, is_sure: bool) -> None:
        self._console, self._is_sure = console, is_sure
        self._latest_s = math.inf
        """When the study should have ended, as it was told; infinite before."""
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
        is_to_ask = len(jobs) > MANY_RUNS and not self._is_sure
        if is_to_ask and not (sys.stdin.isatty() and self._console.is_terminal):
            what = f"{len(jobs)} runs are pending, and cannot ask for confirmation: not a terminal"
            raise UserError.of(what, "add --yes, or use fewer seeds")
        with study_bar(self._errors, run.plan.name, total - len(jobs), total, run.left_s) as on_made:
            jobs = run.make_first(jobs, on_made, self.failed)
        found = run.estimate(jobs)
        text = "" if found is None else estimate_text(found, run.workers.at_once, if_needed=run.plan.until_clear)
        if is_to_ask and not _wants(text or f"{len(jobs)} runs are pending", self._console):
            self._console.print("no more runs; --seeds and --vary make the study smaller")
            return None
        if not is_to_ask and found is not None and found.max_s >= WORTH_TELLING_S:
            self._console.print(text, markup=False)
            self._latest_s = time.monotonic() + found.max_s
        return jobs

    @contextmanager
    def progress(
        self, title: str, done: int, total: int, left_s: Callable[[], float | None] | None = None
    ) -> Iterator[Callable[[str], None]]:
        """Show the progress bar; tell the time left where none was told before, or where it is more than was told."""
        with study_bar(self._errors, title, done, total, left_s) as show:
            made = done

            def on_made(outcome: str) -> None:
                nonlocal made
                show(outcome)
                made += 1
                left = left_s() if left_s is not None else None
                if left is None or left < WORTH_TELLING_S:
                    return
                end_s = time.monotonic() + left
                if math.isinf(self._latest_s) or end_s > self._latest_s:
                    self._latest_s = end_s + LATER * left
                    self._errors.print(f"{total - made} runs left, about {duration_text(left)}", markup=False)

            yield on_made

    def failed(self, text: str) -> None:
        """Print a failed run above the progress bar."""
        self._errors.print(text, markup=False, style="red")

    def tell(self, line: str) -> None:
        """Print a line."""
        self._console.print(line, markup=False)


def estimate_text(found: TimeEstimate, at_once: int, *, if_needed: bool = False) -> str:
    """Return how long runs will probably take; ``if_needed``: the results decide how many are made."""
    condition = ", if the results need all worlds" if if_needed else ""
    probable, lowest, highest = map(duration_text, (found.wall_s, found.min_s, found.max_s))
    span = f"{probable} ({lowest} to {highest})"
    return f"{found.n_runs} runs left, {at_once} at once: about {span}, with pictures and report{condition}"


def _wants(text: str, console: Console) -> bool:
    """Ask for confirmation of many runs."""
    try:
        return console.input(f"{text}. Continue? [y/N] ", markup=False).strip().lower() in {"y", "yes"}
    except EOFError:
        return False


def duration_text(seconds: float) -> str:
    """Return a duration in words, of two digits at most."""
    for unit, size in (("days", 86400), ("hours", 3600), ("minutes", 60)):
        if seconds >= 2 * size:
            return f"{seconds / size:.2g} {unit}" if seconds < 10 * size else f"{seconds / size:.0f} {unit}"
    return f"{max(seconds, 1):.0f} seconds"
