"""The flow of a study, from its checked plan to the report: what the command and `graphnav.ablate` share."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Protocol

from graphnav import GraphnavError
from graphnav.core.catalog import Catalog
from graphnav.core.runner import Outcome
from graphnav.studies.ablation.execution import (
    RunTimes,
    StudyFolder,
    TaskFactory,
    TimeEstimate,
    Workers,
    cluster_workers,
    draw_failures,
    execute,
    local_workers,
    pending_drawings,
    pending_jobs,
)
from graphnav.studies.ablation.plan import CheckedStudy, Job
from graphnav.studies.ablation.report import EarlyMaps
from graphnav.studies.ablation.results import (
    Record,
    expected_failures,
    failed_run_text,
    read_records,
    worst_failures,
)
from graphnav.studies.ablation.stopping import jobs_of_next_round
from graphnav.studies.ablation.worker import STALL_S, Result
from graphnav.studies.api.study_files import StudyFiles, write_study_files


@dataclass(frozen=True)
class ExecutionOptions:
    """How the runs of a study are made."""

    jobs: int | None
    """Runs at once; None: one a core."""
    cluster: str | None
    """The scheduler of a Dask cluster that makes the runs; None: this machine."""
    gallery: int
    """How many failures of each variant are run again and drawn."""
    keep_logs: bool
    fail_fast: bool = False
    """Whether the first run in which a stage fails or whose process dies ends the study."""
    stall_s: float = STALL_S
    """The longest time that one call into a stage may take, seconds of wall time."""


WORTH_TELLING_S = 30.0
"""The time of a study that takes less is not told."""
FIRST_S = 30.0
"""So long are runs made to learn how long the others take; those that are under way then end."""
FIRST_SHARE = 0.1
"""At most so many of the runs are made for it."""
PRECISE = 0.07
"""An estimate with this error, over the time, needs no more runs."""
FEW_RUNS = 10
"""Fewer runs are made without an estimate: a part of them would take as long as all, and tell little."""
DRAWING_S = 3.0
"""The time to draw a failure, beside its run."""
REPORT_S = 2.0
"""The time of tables and report after the last run."""


class FailFastError(GraphnavError):
    """The failed run that ended a study."""


class StudyRun:
    """A study while its runs are made."""

    def __init__(
        self, study: CheckedStudy, catalog: Catalog, folder: StudyFolder, workers: Workers, options: ExecutionOptions
    ) -> None:
        self.plan, self.workers, self.options = study.plan, workers, options
        self._folder, self._tasks = folder, TaskFactory(study, stall_s=options.stall_s)
        self._times, self._unmade = RunTimes(self._tasks.until_s), dict[str, Job]()
        self._maps = EarlyMaps(study.plan, catalog, folder.path)

    def pending(self) -> list[Job]:
        """Return the runs that do not exist yet; the others tell how long they take."""
        pending = pending_jobs(self.plan, self._folder)
        if len(pending) < self.plan.n_jobs:
            cases = {(case.graph, case.variant): case for case in self.plan.cases if not case.same_as}
            for record in read_records(self.plan, self._folder.path):
                if case := cases.get((record.graph, record.variant)):
                    self._times.add(Job(case, record.seed), record.wall_s)
        self._unmade = {job.folder: job for job in next(self.batches(pending), ())}
        return pending

    def make(
        self,
        jobs: Sequence[Job],
        on_made: Callable[[str], None] = lambda _: None,
        on_failed: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Make runs; ``on_made`` gets the outcome of each, ``on_failed`` the text of those in which a stage failed.

        Raises
        ------
        FailFastError
            With ``fail_fast``, at the first run that fails, and at once where an existing one did.
        """
        fail_fast = self.options.fail_fast

        def failed(record: Record) -> None:
            text = failed_run_text(record, self._folder.path)
            if fail_fast:
                raise FailFastError(text)
            on_failed(text)

        def died(job: Job) -> None:
            if fail_fast:
                raise FailFastError(f"failed: {job.case.graph}, {job.case.variant}, seed {job.seed}: its process died")

        for record in read_records(self.plan, self._folder.path) if fail_fast else ():
            if record.outcome == Outcome.FAILED:
                failed(record)

        def kept(job: Job, result: Result) -> None:
            self._unmade.pop(job.folder, None)
            if not result.died:
                self._times.add(job, result.took_s - result.set_up_s, result.set_up_s)
            self._maps.add(job)

        self._unmade |= {job.folder: job for job in jobs}
        execute(jobs, self._tasks, self._folder, self.workers, on_made, failed, on_kept=kept, on_died=died)

    def make_first(
        self, jobs: Sequence[Job], on_made: Callable[[str], None], on_failed: Callable[[str], None]
    ) -> list[Job]:
        """Make some of the `pending` runs, from all over a study, until they tell the time of the others; return these.

        They are runs of the study like any other, and take `FIRST_S` and the rest of one run at most.

        Raises
        ------
        FailFastError
            As of `make`.
        """
        left, at_once, end_s = {job.folder: job for job in jobs}, self.workers.at_once, time.monotonic() + FIRST_S
        spread = self._times.spread(list(self._unmade.values()))
        n_first = len(jobs) * FIRST_SHARE if len(jobs) >= FEW_RUNS else 0
        while (n_made := len(jobs) - len(left)) < n_first and time.monotonic() < end_s and self._knows_too_little(left):
            chosen = list(islice(spread, max(at_once, min(2 * at_once, round(n_first - n_made)))))
            if not chosen:
                break
            self.make(chosen, on_made, on_failed)
            for job in chosen:
                del left[job.folder]
        return list(left.values())

    def _knows_too_little(self, left: Mapping[str, Job]) -> bool:
        """Return whether more runs would tell the time of a study that takes long."""
        found = self._times.estimate(left.values(), self.workers.at_once)
        return found is None or (found.max_s >= WORTH_TELLING_S and found.error_s > PRECISE * found.wall_s)

    def estimate(self, jobs: Sequence[Job]) -> TimeEstimate | None:
        """Return the time of runs, of the pictures of their failures and of the report; None before some are made."""
        at_once = self.workers.at_once
        found = self._times.estimate(jobs, at_once)
        if found is None:
            return None
        records = read_records(self.plan, self._folder.path)
        drawn = expected_failures(self.plan, records, self.options.gallery)
        end_s = drawn * (found.wall_s / max(found.n_runs, 1) + DRAWING_S / at_once) + REPORT_S
        return replace(found, wall_s=found.wall_s + end_s, error_s=found.error_s + end_s / 3)

    def left_s(self) -> float | None:
        """Return the wall time of the runs that `make` has still to make; None before there are some."""
        found = self._times.estimate(self._unmade.values(), self.workers.at_once)
        return None if found is None else found.wall_s

    def batches(self, jobs: Sequence[Job]) -> Iterator[Sequence[Job]]:
        """Yield the accepted runs: all at once or, where the results decide, those of one round after another."""
        if not self.plan.until_clear:
            yield jobs
            return

        def is_made(job: Job) -> bool:
            return self._folder.holds(job.folder)

        while batch := jobs_of_next_round(self.plan, read_records(self.plan, self._folder.path), is_made):
            yield batch

    @property
    def drawn(self) -> frozenset[Path]:
        """The maps with paths that were drawn while runs were made."""
        return frozenset(self._maps.drawn)

    def draw(self, observer: StudyObserver) -> None:
        """Draw the worst failures that are not drawn yet."""
        options = self.options
        chosen = worst_failures(self.plan, read_records(self.plan, self._folder.path), options.gallery)
        jobs = pending_drawings(chosen, self._folder, keep_logs=options.keep_logs)
        with observer.progress("failures", len(chosen) - len(jobs), len(chosen)) as on_made:
            lines = draw_failures(jobs, self._tasks, self._folder, self.workers, on_made, keep_logs=options.keep_logs)
        for line in lines:
            observer.tell(line)


class StudyObserver(Protocol):
    """Observer of a study: accepts its runs, follows their progress, receives messages."""

    def accept(self, run: StudyRun) -> Sequence[Job] | None:
        """Return the runs to make of those that are pending, or None to make none and end here."""

    def progress(
        self, title: str, done: int, total: int, left_s: Callable[[], float | None] | None = None
    ) -> AbstractContextManager[Callable[[str], None]]:
        """Return what takes the outcome of each run that is made; ``left_s`` tells how long the others take."""

    def failed(self, text: str) -> None:
        """Tell of a run in which a stage failed, as soon as it is made."""

    def tell(self, line: str) -> None:
        """Tell of a failure that did not happen again, or could not be drawn."""


def run_study(
    study: CheckedStudy, catalog: Catalog, folder: StudyFolder, options: ExecutionOptions, observer: StudyObserver
) -> StudyFiles | None:
    """Make the pending runs, draw failures, write tables and report; return None where the runs are not accepted.

    Raises
    ------
    UserError
        The folder holds another study, or no workers can be had.
    FailFastError
        The first failed run, where the options ask to stop at it.
    GraphnavError
        What ends a study: a full disk, a cluster that is gone. Every finished run is in the folder.
    """
    plan = study.plan
    folder.begin(plan)
    with workers_of(options.jobs, options.cluster, folder.scratch) as workers:
        run = StudyRun(study, catalog, folder, workers, options)
        jobs = observer.accept(run)
        if jobs is None:
            return None
        with observer.progress(plan.name, plan.n_jobs - len(jobs), plan.n_jobs, run.left_s) as on_made:
            for batch in run.batches(jobs):
                run.make(batch, on_made, observer.failed)
        run.draw(observer)
    return write_study_files(plan, folder.path, catalog, study.graphs, run.drawn)


def workers_of(jobs: int | None, cluster: str | None, scratch: Path) -> AbstractContextManager[Workers]:
    """Return what makes runs: a Dask cluster, or processes of this machine that work in ``scratch``.

    Raises
    ------
    UserError
        Dask is not installed, or no scheduler answers.
    """
    return cluster_workers(cluster) if cluster else local_workers(jobs or _cores(), scratch)


def _cores() -> int:
    """Return the number of cores that this process may use."""
    from joblib import cpu_count

    return int(cpu_count())
