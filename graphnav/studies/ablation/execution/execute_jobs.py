"""Make the pending runs of a plan."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from graphnav.core.errors import GraphnavError
from graphnav.core.runner import Outcome
from graphnav.core.runner.recording.summary import SUMMARY
from graphnav.studies.ablation.execution.crashed_run import crashed_run_files
from graphnav.studies.ablation.execution.study_folder import StudyFolder
from graphnav.studies.ablation.execution.task_factory import TaskFactory
from graphnav.studies.ablation.execution.workers import Workers
from graphnav.studies.ablation.plan import Job, Plan
from graphnav.studies.ablation.results import Record, read_record
from graphnav.studies.ablation.worker import Result, Task


def pending_jobs(plan: Plan, folder: StudyFolder) -> list[Job]:
    """Return the runs of a plan that are pending."""
    return [job for job in plan.jobs if not folder.holds(job.folder)]


def execute(
    jobs: Iterable[Job],
    tasks: TaskFactory,
    folder: StudyFolder,
    workers: Workers,
    on_made: Callable[[str], None] = lambda _: None,
    on_failed: Callable[[Record], None] = lambda _: None,
    *,
    on_died: Callable[[Job], None] = lambda _: None,
) -> None:
    """Make runs, in parallel, and keep each as soon as it is made; ``on_made`` gets its outcome.

    A failing stage is a result, which ``on_failed`` gets at once. A run whose process died is made once more when all
    others are done, alone, for it may have lacked memory; if it dies again, that is its result. ``on_died`` gets it
    when it dies first; it may raise, and so may ``on_failed``.

    Raises
    ------
    GraphnavError
        Something that has nothing to do with the stages: a full disk, a machine with other versions.
    """
    made = {job.folder: job for job in jobs}
    for result in perform_all(map(tasks.task, made.values()), workers, lambda task: on_died(made[task.folder])):
        if result.died:
            folder.keep(result.task.folder, crashed_run_files(result))
        else:
            folder.keep(result.task.folder, result.files)
        outcome = Outcome.FAILED if result.died else result.outcome
        on_made(outcome)
        if outcome == Outcome.FAILED:
            job = made[result.task.folder]
            on_failed(read_record(job.case, job.seed, folder.path / job.folder / SUMMARY))


def perform_all(
    tasks: Iterable[Task], workers: Workers, on_died: Callable[[Task], None] = lambda _: None
) -> Iterator[Result]:
    """Yield what comes of tasks; those that died have done so twice, and ``on_died`` got them the first time."""
    died = []
    for result in workers.perform_all(tasks):
        if result.died:
            on_died(result.task)
            died.append(result.task)
        else:
            yield _without_error(result)
    yield from map(_without_error, workers.perform_all(died, one_at_a_time=True))


def _without_error(result: Result) -> Result:
    if result.error:
        raise GraphnavError(result.error)
    return result
