"""Run the worst failures again with everything recorded, and draw them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from graphnav.core.record import LOG
from graphnav.core.runner import Outcome
from graphnav.core.runner.recording.summary import SUMMARY
from graphnav.studies.ablation.execution.execute_jobs import perform_all
from graphnav.studies.ablation.execution.study_folder import StudyFolder
from graphnav.studies.ablation.execution.task_factory import TaskFactory
from graphnav.studies.ablation.execution.workers import Workers
from graphnav.studies.ablation.plan import Job
from graphnav.studies.ablation.results import failure_folder, read_record
from graphnav.studies.ablation.worker import NOT_DRAWN

_CHANGED = "not the same again"


def pending_drawings(jobs: Iterable[Job], folder: StudyFolder, *, keep_logs: bool) -> list[Job]:
    """Return the failures that are still to be drawn, those among them that could not be."""
    wanted = LOG if keep_logs else SUMMARY
    places = {folder.path / failure_folder(job.case, job.seed): job for job in jobs}
    return [job for at, job in places.items() if not (at / wanted).is_file() or (at / NOT_DRAWN).is_file()]


def draw_failures(
    jobs: Sequence[Job],
    tasks: TaskFactory,
    folder: StudyFolder,
    workers: Workers,
    on_made: Callable[[str], None] = lambda _: None,
    *,
    keep_logs: bool,
) -> list[str]:
    """Run failures again, draw them, keep the pictures; return messages for the user, normally none.

    There is one for each run that ended otherwise than before, and for each that could not be drawn.
    """
    wanted = {failure_folder(job.case, job.seed): job for job in jobs}
    again = (
        replace(tasks.task(job), folder=place, record="all", draws=True, keeps_log=keep_logs)
        for place, job in wanted.items()
    )
    said = []
    for result in perform_all(again, workers):
        place, job = result.task.folder, wanted[result.task.folder]
        if result.died:
            said.append(f"{_CHANGED}: {job.folder}: its process died when it was run again with everything recorded")
        else:
            folder.keep(place, result.files)
            before, after = (_ending(folder, job, where) for where in (job.folder, place))
            if before != after:
                said.append(f"{_CHANGED}: {job.folder}: {before}, but {after} when it was run again")
            if why := result.files.get(NOT_DRAWN):
                said.append(f"not drawn: {job.folder}: {why.decode()}")
        on_made(Outcome.FAILED if result.died else result.outcome)
    return said


def _ending(folder: StudyFolder, job: Job, place: str) -> str:
    record = read_record(job.case, job.seed, folder.path / place / SUMMARY)
    return f"{record.outcome} after {record.frames} frames"
