"""The flow of a study, from its checked plan to the report: what the command and `graphnav.ablate` share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
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
    estimate_time,
    execute,
    local_workers,
    pending_drawings,
    pending_jobs,
)
from graphnav.studies.ablation.plan import CheckedStudy, Job
from graphnav.studies.ablation.report import EarlyMaps
from graphnav.studies.ablation.results import Record, failed_run_text, read_records, worst_failures
from graphnav.studies.ablation.stopping import jobs_of_next_round
from graphnav.studies.ablation.worker import STALL_S
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


class FailFastError(GraphnavError):
    """The failed run that ended a study."""


class StudyRun:
    """A study while its runs are made."""

    def __init__(
        self, study: CheckedStudy, catalog: Catalog, folder: StudyFolder, workers: Workers, *, stall_s: float
    ) -> None:
        self.plan, self.workers = study.plan, workers
        self._folder, self._tasks = folder, TaskFactory(study, stall_s=stall_s)
        self._times, self._unmade = RunTimes(), dict[str, Job]()
        self._maps = EarlyMaps(study.plan, catalog, folder.path)

    def pending(self) -> list[Job]:
        """Return the runs that do not exist yet."""
        return pending_jobs(self.plan, self._folder)

    def make(
        self,
        jobs: Sequence[Job],
        on_made: Callable[[str], None] = lambda _: None,
        on_failed: Callable[[str], None] = lambda _: None,
        *,
        fail_fast: bool = False,
    ) -> None:
        """Make runs; ``on_made`` gets the outcome of each, ``on_failed`` the text of those in which a stage failed.

        Raises
        ------
        FailFastError
            With ``fail_fast``, at the first run that fails, and at once where an existing one did.
        """

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

        def kept(job: Job, took_s: float) -> None:
            self._unmade.pop(job.folder, None)
            self._times.add(job.case, took_s)
            self._maps.add(job)

        self._unmade = {job.folder: job for job in jobs}
        execute(jobs, self._tasks, self._folder, self.workers, on_made, failed, on_kept=kept, on_died=died)

    def left_s(self) -> float | None:
        """Return the wall time of the runs that `make` has still to make; None before each graph has some.

        A run takes as long as those of its case did, one of a case without any as those of its graph.
        """
        return self._times.left_s(self._unmade.values(), self.workers.at_once)

    def batches(self, jobs: Sequence[Job]) -> Iterator[Sequence[Job]]:
        """Yield the accepted runs: all at once or, where the results decide, those of one round after another."""
        if not self.plan.until_clear:
            yield jobs
            return

        def is_made(job: Job) -> bool:
            return self._folder.holds(job.folder)

        while batch := jobs_of_next_round(self.plan, read_records(self.plan, self._folder.path), is_made):
            yield batch

    def estimate(self, jobs: Sequence[Job]) -> TimeEstimate:
        """Return the time of runs, if each lasted until its limit; may make a short run of each graph."""
        return estimate_time(jobs, read_records(self.plan, self._folder.path), self._tasks, self.workers)

    def seconds_a_run(self) -> float:
        """Return the mean wall time of the existing runs, of which there is at least one."""
        walls = [record.wall_s for record in read_records(self.plan, self._folder.path)]
        return sum(walls) / len(walls)

    @property
    def drawn(self) -> frozenset[Path]:
        """The maps with paths that were drawn while runs were made."""
        return frozenset(self._maps.drawn)

    def draw(self, options: ExecutionOptions, observer: StudyObserver) -> None:
        """Draw the worst failures that are not drawn yet."""
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
        run = StudyRun(study, catalog, folder, workers, stall_s=options.stall_s)
        jobs = observer.accept(run)
        if jobs is None:
            return None
        with observer.progress(plan.name, plan.n_jobs - len(jobs), plan.n_jobs, run.left_s) as on_made:
            for batch in run.batches(jobs):
                run.make(batch, on_made, observer.failed, fail_fast=options.fail_fast)
        run.draw(options, observer)
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
