"""The time that runs take, learned from those that are made: which is begun first, and how long the others last."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from statistics import fmean

from graphnav.studies.ablation.plan import Case, Job

ENOUGH = 3
"""Runs of a graph that tell how long its others last: the first in a world takes longer than those that follow."""


class RunTimes:
    """The wall time of runs from start to end, by case and by graph."""

    def __init__(self) -> None:
        self._cases: dict[str, list[float]] = {}
        self._graphs: dict[str, list[float]] = {}

    def add(self, case: Case, took_s: float) -> None:
        """Add a run that was made."""
        self._cases.setdefault(case.folder, []).append(took_s)
        self._graphs.setdefault(case.graph, []).append(took_s)

    def of(self, case: Case) -> float | None:
        """Return the mean of the runs of a case, else of its graph; None where too few of this are made."""
        of_graph = self._graphs.get(case.graph, [])
        return fmean(self._cases.get(case.folder) or of_graph) if len(of_graph) >= ENOUGH else None

    def left_s(self, jobs: Iterable[Job], at_once: int) -> float | None:
        """Return the wall time of runs that are made ``at_once``; None as long as too few of a graph are made."""
        found = [self.of(job.case) for job in jobs]
        known = [seconds for seconds in found if seconds is not None]
        return sum(known) / at_once if len(known) == len(found) else None


def longest_first(jobs: Sequence[Job], until_s: Callable[[Job], float | None]) -> list[Job]:
    """Return jobs seed by seed as before, but of each seed the graphs with the longest runs first.

    Then the last runs of a study are short, and no process is long without work while another makes the last one.
    ``until_s``: the time limit of a run; one without a limit counts as the longest.
    """
    seeds = {seed: place for place, seed in enumerate(dict.fromkeys(job.seed for job in jobs))}
    limits: dict[str, float] = {}
    for job in jobs:
        limit = until_s(job)
        limits[job.case.source] = max(limits.get(job.case.source, 0.0), float("inf") if limit is None else limit)
    return sorted(jobs, key=lambda job: (seeds[job.seed], -limits[job.case.source]))
