"""Let rivals take turns and compare what they cost: the harness of the benchmarks.

Each round measures every rival once and begins with another one than the round before, so that all meet the same noise
of the machine. Ratios are of one round, and their interval tells how far to trust their median. pyperf,
pytest-benchmark and asv measure one rival after the other: where the machine slows down meanwhile, so does the second.
"""

from __future__ import annotations

import math
import os
import statistics
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import accumulate
from typing import TypeVar

T = TypeVar("T")
Clock = Callable[[], float]
"""`time.perf_counter`, or `time.thread_time` where other programs are not to count; s."""
_ERROR = 0.05
"""The chance that an interval does not hold the true median."""


@dataclass(frozen=True)
class Ratio:
    """The median of the rounds' ratios, with its interval of 95 %, or all that there is of few rounds."""

    median: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.median:.2f} [{self.low:.2f}, {self.high:.2f}]"

    @classmethod
    def of(cls, ratios: Sequence[float]) -> Ratio:
        """Return it by the ranks between which the median of any distribution lies with this chance."""
        ordered, n = sorted(ratios), len(ratios)
        chances = accumulate(math.comb(n, rank) / 2**n for rank in range(n))
        first = max((rank for rank, below in enumerate(chances) if below <= _ERROR / 2), default=0)
        return cls(statistics.median(ordered), ordered[first], ordered[n - 1 - first])


@dataclass(frozen=True)
class Turns:
    """Costs of each rival in each round."""

    costs: Mapping[str, Sequence[float]]

    def median(self, name: str) -> float:
        """Return the median cost of a rival."""
        return statistics.median(self.costs[name])

    def ratio(self, name: str, reference: str) -> Ratio:
        """Return the cost of a rival over that of another in the same round."""
        return Ratio.of([a / b for a, b in zip(self.costs[name], self.costs[reference], strict=True)])


def take_turns(rivals: Mapping[str, Callable[[], float]], rounds: int, warm_up: int = 1) -> Turns:
    """Let each rival return its cost once a round; the first ``warm_up`` rounds do not count."""
    return Turns(results_in_turn(rivals, rounds, warm_up))


def results_in_turn(rivals: Mapping[str, Callable[[], T]], rounds: int, warm_up: int = 0) -> dict[str, list[T]]:
    """Return what each rival returned in each round, where that is more than one cost."""
    names = list(rivals)
    results: dict[str, list[T]] = {name: [] for name in names}
    for _ in range(warm_up + rounds):
        for name in names:
            results[name].append(rivals[name]())
        names.append(names.pop(0))
    return {name: found[warm_up:] for name, found in results.items()}


def timed(act: Callable[[], object], clock: Clock = time.perf_counter, times: int = 1) -> Callable[[], float]:
    """Return a rival that does something ``times`` times and returns the time of one, s."""

    def cost() -> float:
        begin = clock()
        for _ in range(times):
            act()
        return (clock() - begin) / times

    return cost


@contextmanager
def load_told() -> Iterator[None]:
    """Print the machine's load before and after a benchmark: what else ran is in every wall time."""

    def told(when: str) -> None:
        averages = ", ".join(f"{load:.2f}" for load in os.getloadavg())
        print(f"load {when}: {averages} (1, 5, 15 min) on {os.cpu_count()} cores, {len(os.sched_getaffinity(0))} ours")

    told("before")
    try:
        yield
    finally:
        told("after")
