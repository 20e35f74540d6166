"""The gallery: the worst failures, run again with everything recorded, and drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from graphnav.ablation.execution.execute_jobs import perform_all
from graphnav.ablation.execution.study_folder import StudyFolder
from graphnav.ablation.plan.plan import RUNS, Case, Job, Plan
from graphnav.ablation.results.records import Record, read_record
from graphnav.ablation.execution.task_factory import Tasks
from graphnav.ablation.worker.perform_task import NOT_DRAWN
from graphnav.ablation.execution.workers import Workers
from graphnav.record import LOG
from graphnav.runner import Outcome
from graphnav.runner.recorded import SUMMARY

FAILURES = "failures"
_WORST = (Outcome.CONTACT, Outcome.FAILED, Outcome.TIMEOUT)
"""A failure that is hard to explain by its summary comes first."""
_CHANGED = "not the same again"
_OF_CONTROLS = 1
"""Controls fail by design: one picture shows how."""


def failure_folder(case: Case, seed: int) -> str:
    """Return where a failure's pictures are, below the study's folder."""
    return f"{FAILURES}/{case.folder.removeprefix(f'{RUNS}/')}/{seed}"


def is_failure(record: Record) -> bool:
    """Return whether a run failed: it touched something, broke down, or had a goal and did not reach it in time.

    A graph without a goal ends when its time is over, which is no failure.
    """
    if record.outcome == Outcome.TIMEOUT:
        return any(name.endswith(".success") and value == 0 for name, value in record.figures.items())
    return record.outcome in _WORST


def worst_failures(plan: Plan, records: Iterable[Record], each: int) -> list[Job]:
    """Return up to ``each`` failures of every case: contacts, then breakdowns, then timeouts, by seed.

    Runs that left nothing to see, because they broke down before the first tick, do not count.
    """
    failed: dict[tuple[str, str], list[Record]] = {}
    for record in records:
        if is_failure(record) and record.frames:
            failed.setdefault((record.graph, record.variant), []).append(record)
    chosen = []
    for case in plan.cases:
        if case.same_as:
            continue
        found = sorted(
            failed.get((case.graph, case.variant), ()), key=lambda r: (_WORST.index(Outcome(r.outcome)), r.seed)
        )
        number = min(each, _OF_CONTROLS) if case.role == "control" else each
        chosen += [Job(case, record.seed) for record in found[:number]]
    return chosen


def undrawn(jobs: Iterable[Job], folder: StudyFolder, *, keep_logs: bool) -> list[Job]:
    """Return the failures that are still to be drawn, those among them that could not be."""
    wanted = LOG if keep_logs else SUMMARY
    places = {folder.path / failure_folder(job.case, job.seed): job for job in jobs}
    return [job for at, job in places.items() if not (at / wanted).is_file() or (at / NOT_DRAWN).is_file()]


def draw_failures(
    jobs: Sequence[Job],
    tasks: Tasks,
    folder: StudyFolder,
    workers: Workers,
    on_made: Callable[[str], None] = lambda _: None,
    *,
    keep_logs: bool,
) -> list[str]:
    """Run failures again, draw them, keep the pictures; return what is to be said, which should be nothing.

    That is what did not end as it had, and what could not be drawn.
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
