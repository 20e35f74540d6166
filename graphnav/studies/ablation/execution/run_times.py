"""The time that runs take, learned from those that are made: how long the others last, and which is begun first."""

from __future__ import annotations

import math
from bisect import bisect
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate

from graphnav.studies.ablation.execution.local_processes import RUNS_IN_A_ROW
from graphnav.studies.ablation.plan import Job

ENOUGH = 3
"""So many runs tell how long the others last: the first in a world takes longer than those that follow."""
UNLIMITED_S = 60.0
"""A run without a time limit counts as one of so many simulated seconds, until some are made."""
_OF_OTHERS = 2.0
"""Other graphs, and other variants of a graph, count as much as so many runs."""
_GOLDEN_RATIO = (math.sqrt(5) - 1) / 2
_DEVIATIONS = 1.5
"""Half of an interval in which most studies end, in standard errors; and what a machine with other work adds."""
_OF_MACHINE = 0.05
_BETWEEN = 1.04
"""The time from the begin of a run to the begin of the next in a process, over the time of the run."""


@dataclass(frozen=True)
class TimeEstimate:
    """The wall time that runs probably take, with all processes at work."""

    n_runs: int
    wall_s: float
    error_s: float
    """Most studies take between so much less and so much more."""

    @property
    def min_s(self) -> float:
        """Return less than most studies take."""
        return max(self.wall_s - self.error_s, self.wall_s / 3)

    @property
    def max_s(self) -> float:
        """Return more than most studies take."""
        return self.wall_s + self.error_s


class _Sample:
    """Measured values: how many, their sum and the sum of their squares."""

    def __init__(self) -> None:
        self.n, self._sum, self._squares = 0, 0.0, 0.0

    def add(self, value: float) -> None:
        """Add one."""
        self.n, self._sum, self._squares = self.n + 1, self._sum + value, self._squares + value**2

    def mean(self, of_others: float) -> float:
        """Return the mean, the nearer to that of others the fewer runs there are."""
        return (self._sum + _OF_OTHERS * of_others) / (self.n + _OF_OTHERS)

    @property
    def own_mean(self) -> float:
        """Return the mean of at least one."""
        return self._sum / self.n

    @property
    def variance(self) -> float:
        """Return the variance of at least two."""
        return max(0.0, self._squares - self._sum**2 / self.n) / (self.n - 1)


class RunTimes:
    """The wall time of drives, over their time limits, by graph and case; and that of worlds until a drive begins.

    A drive takes what those of its case did and, the fewer these are, what those of its graph and of all graphs did.
    Methods that fail early make all of them shorter than their limits.
    """

    def __init__(self, until_s: Callable[[Job], float | None]) -> None:
        self._until_s = until_s
        self._all, self._set_up = _Sample(), _Sample()
        self._worlds = set[tuple[str, int]]()
        self._graphs: dict[str, _Sample] = {}
        self._cases: dict[str, _Sample] = {}

    def add(self, job: Job, drove_s: float, set_up_s: float | None = None) -> None:
        """Add a run that was made; the first through its world tells how long a world takes to make."""
        world = job.case.graph, job.seed
        if set_up_s is not None and world not in self._worlds:
            self._worlds.add(world)
            self._set_up.add(set_up_s)
        ratio = drove_s / self._limit_s(job)
        self._all.add(ratio)
        self._graphs.setdefault(job.case.graph, _Sample()).add(ratio)
        self._cases.setdefault(job.case.folder, _Sample()).add(ratio)

    def estimate(self, jobs: Iterable[Job], at_once: int) -> TimeEstimate | None:
        """Return the time of runs that are made ``at_once``; None as long as too few others are made.

        Its error is that of means: the fewer runs of a graph are made, and the more they differ, the larger.
        """
        if self._all.n < ENOUGH:
            return None
        n_runs, limits, worlds = 0, dict[str, dict[str, float]](), Counter[tuple[str, int]]()
        for job in jobs:
            n_runs += 1
            worlds[job.case.graph, job.seed] += 1
            of_cases = limits.setdefault(job.case.graph, {})
            of_cases[job.case.folder] = of_cases.get(job.case.folder, 0.0) + self._limit_s(job)
        core_s, variance, none = 0.0, 0.0, _Sample()
        for graph, of_cases in limits.items():
            made = self._graphs.get(graph, none)
            of_graph = made.mean(self._all.own_mean)
            core_s += sum(limit_s * self._cases.get(case, none).mean(of_graph) for case, limit_s in of_cases.items())
            of_one = (made if made.n >= ENOUGH else self._all).variance
            variance += sum(of_cases.values()) ** 2 * of_one / (made.n + _OF_OTHERS)
        if self._set_up.n:
            core_s += self._set_up.own_mean * sum(math.ceil(n / RUNS_IN_A_ROW) for n in worlds.values())
        error_s = _DEVIATIONS * math.sqrt(variance) + _OF_MACHINE * core_s
        return TimeEstimate(n_runs, core_s * _BETWEEN / at_once, error_s * _BETWEEN / at_once)

    def spread(self, jobs: Sequence[Job]) -> Iterator[Job]:
        """Yield runs from all over a study, in an order of which any beginning is spread evenly.

        A long run comes first as likely as several short ones of the same length: it tells as much of the time.
        """
        places = {folder: place for place, folder in enumerate(dict.fromkeys(job.case.folder for job in jobs))}
        ordered = sorted(jobs, key=lambda job: places[job.case.folder])
        ends = list(accumulate(map(self._limit_s, ordered)))
        taken = set[int]()
        for number in range(1, 2 * len(ordered)):
            place = bisect(ends, number * _GOLDEN_RATIO % 1.0 * ends[-1])
            if place not in taken:
                taken.add(place)
                yield ordered[place]

    def _limit_s(self, job: Job) -> float:
        return self._until_s(job) or UNLIMITED_S


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
