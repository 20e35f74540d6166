"""Make the pending runs of a plan, and draw its failures."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from graphnav import Graph, GraphnavError
from graphnav.core.graph import resolved_yaml
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome, Summary
from graphnav.core.spec import RecordOption
from graphnav.studies.ablation.execution.run_times import longest_first
from graphnav.studies.ablation.execution.study_folder import StudyFolder
from graphnav.studies.ablation.execution.workers import Workers
from graphnav.studies.ablation.plan import Case, CheckedStudy, Job, Plan
from graphnav.studies.ablation.results import Record, failure_folder, read_record
from graphnav.studies.ablation.worker import NOT_DRAWN, STALL_S, Result, Task


class TaskFactory:
    """Turns the jobs of a checked study into tasks; each graph is written once."""

    def __init__(self, study: CheckedStudy, *, stall_s: float = STALL_S) -> None:
        self._stall_s = stall_s
        self._plan, self._graphs = study.plan, study.graphs
        self._texts: dict[str, str] = {}

    def task(self, job: Job) -> Task:
        """Return what a worker needs to make a run."""
        graph, text = self._graphs[job.case.folder], self._text(job.case)
        return Task(
            folder=job.folder,
            graph_yaml=text,
            graph_path=str(graph.path),
            notices=graph.notices,
            seed=job.seed,
            plugins=self._plan.plugins,
            versions=self._plan.versions,
            record=_record_of(job.case, graph),
            stall_s=self._stall_s,
        )

    def until_s(self, job: Job) -> float | None:
        """Return the time limit of a run, simulated seconds; None without one."""
        return self._graphs[job.case.folder].run.until_s

    def _text(self, case: Case) -> str:
        """Return the YAML of a case's graph that loads from any folder."""
        if case.folder not in self._texts:
            self._texts[case.folder] = self._portable(self._graphs[case.folder])
        return self._texts[case.folder]

    def _portable(self, graph: Graph) -> str:
        plugins = dict.fromkeys((*graph.plugins, *map(Path, self._plan.plugins)))
        return resolved_yaml(replace(graph, plugins=tuple(plugins)), portable_paths=False)


def _record_of(case: Case, graph: Graph) -> RecordOption:
    """Return what the logs of a case keep: what the study asks for, else small messages, whatever its graph says."""
    is_asked = any(override.target.kind == "run" and override.target.key == "record" for override in case.overrides)
    return (is_asked and graph.run.record) or "small"


def pending_jobs(plan: Plan, folder: StudyFolder) -> list[Job]:
    """Return the runs of a plan that are pending."""
    return [job for job in plan.jobs if not folder.holds(job.folder)]


def execute(
    jobs: Sequence[Job],
    tasks: TaskFactory,
    folder: StudyFolder,
    workers: Workers,
    on_made: Callable[[str], None] = lambda _: None,
    on_failed: Callable[[Record], None] = lambda _: None,
    *,
    on_kept: Callable[[Job, Result], None] = lambda _job, _result: None,
    on_died: Callable[[Job], None] = lambda _: None,
) -> None:
    """Make runs, in parallel, and keep each as soon as it is made; ``on_made`` gets its outcome.

    Runs are made seed by seed, those with the longest time limits first; ``on_kept`` gets each and its result.

    A failing stage is a result, which ``on_failed`` gets at once. A run whose process died is made once more when all
    others are done, alone, for it may have lacked memory; if it dies again, that is its result. ``on_died`` gets it
    when it dies first; it may raise, and so may ``on_failed``.

    Raises
    ------
    GraphnavError
        Something that has nothing to do with the stages: a full disk, a machine with other versions.
    """
    made = {job.folder: job for job in longest_first(jobs, tasks.until_s)}
    for result in perform_all(map(tasks.task, made.values()), workers, lambda task: on_died(made[task.folder])):
        if result.died:
            folder.keep(result.task.folder, crashed_run_files(result))
        else:
            folder.keep(result.task.folder, result.files)
        outcome, job = Outcome.FAILED if result.died else result.outcome, made[result.task.folder]
        on_kept(job, result)
        on_made(outcome)
        if outcome == Outcome.FAILED:
            on_failed(read_record(job.case, job.seed, folder.path / job.folder / RunFolder.SUMMARY))


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


DIED = "its process died, twice: it takes more memory than there is, or a stage crashes it"
_CHANGED = "not the same again"


def crashed_run_files(result: Result) -> Mapping[str, bytes]:
    """Return the files of a run that crashed its process: the graph, and a summary with that failure."""
    task = result.task
    summary = Summary(
        outcome=Outcome.FAILED,
        failure=DIED + (f"; the last call was {result.last_call}" if result.last_call else ""),
        cause=DIED,
        graph=Path(task.graph_path).stem,
        seed=task.seed,
        until_s=None,
        frames=0,
        sim_s=0.0,
        wall_s=0.0,
        stages={},
        scores={},
        notices=list(task.notices),
        tap_dropped=0,
        run_id="",
        versions=Summary.versions_here(),
    )
    text = json.dumps(summary.as_json(), indent=1) + "\n"
    return {RunFolder.GRAPH: task.graph_yaml.encode(), RunFolder.SUMMARY: text.encode()}


def pending_drawings(jobs: Iterable[Job], folder: StudyFolder, *, keep_logs: bool) -> list[Job]:
    """Return the failures that are still to be drawn, those among them that could not be."""
    wanted = RunFolder.LOG if keep_logs else RunFolder.SUMMARY
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
    record = read_record(job.case, job.seed, folder.path / place / RunFolder.SUMMARY)
    return f"{record.outcome} after {record.frames} frames"
