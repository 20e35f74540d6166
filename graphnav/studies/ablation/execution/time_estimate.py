"""The time that pending runs take until their limits, from the pace of each graph."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome
from graphnav.studies.ablation.execution.execute_jobs import TaskFactory
from graphnav.studies.ablation.execution.workers import Workers
from graphnav.studies.ablation.plan import Job
from graphnav.studies.ablation.results import Record

MEASURED_S = 2.0
"""Simulated seconds of the run that measures the pace of a graph of which no run exists."""


@dataclass(frozen=True)
class TimeEstimate:
    """The time of runs, if each lasted until its time limit."""

    n_runs: int
    core_s: float
    """Seconds of one core for all runs that have a limit and whose graph's pace is known."""
    n_unknown: int
    """Runs without a time limit, or of a graph whose pace could not be measured."""
    n_unlimited: int
    """Those of them that have no time limit."""


def estimate_time(jobs: Sequence[Job], records: Iterable[Record], tasks: TaskFactory, workers: Workers) -> TimeEstimate:
    """Return the time of runs, by the pace of the existing ones of their graph, else by a short run of the first.

    What is measured is the case that comes first, normally the base; variants may be slower.
    """
    paces = _paces_of(records)
    first: dict[str, Job] = {}
    for job in jobs:
        if job.case.graph not in paces and tasks.until_s(job) is not None:
            first.setdefault(job.case.graph, job)
    paces |= dict(_measured(first, tasks, workers))
    limits = [(paces.get(job.case.graph), tasks.until_s(job)) for job in jobs]
    known = [pace * until_s for pace, until_s in limits if pace is not None and until_s is not None]
    n_unlimited = sum(until_s is None for _, until_s in limits)
    return TimeEstimate(len(jobs), sum(known), len(jobs) - len(known), n_unlimited)


def _paces_of(records: Iterable[Record]) -> dict[str, float]:
    """Return wall seconds per simulated second, by graph."""
    wall_s: dict[str, float] = {}
    sim_s: dict[str, float] = {}
    for record in records:
        wall_s[record.graph] = wall_s.get(record.graph, 0.0) + record.wall_s
        sim_s[record.graph] = sim_s.get(record.graph, 0.0) + record.sim_s
    return {graph: wall_s[graph] / total for graph, total in sim_s.items() if total > 0}


def _measured(jobs: Mapping[str, Job], tasks: TaskFactory, workers: Workers) -> Iterator[tuple[str, float]]:
    graphs = {job.folder: graph for graph, job in jobs.items()}
    for result in workers.perform_all(tasks.short_task(job, MEASURED_S) for job in jobs.values()):
        if result.died or result.error or result.outcome == Outcome.FAILED:
            continue
        summary = json.loads(result.files[RunFolder.SUMMARY])
        if summary["sim_s"] > 0:
            yield graphs[result.task.folder], summary["wall_s"] / summary["sim_s"]
