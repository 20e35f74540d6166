"""A trial: the parameters of a rival, and what came of them in every world."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from graphnav.stage import Better

DEFAULT = 0
"""The number of every rival's first trial, which changes no parameter."""


@dataclass(frozen=True)
class Trial:
    """The parameters that a rival was tried with, and its results."""

    rival: str
    number: int
    params: Mapping[str, Any]
    """By ``stage.parameter``; empty for the first trial, which leaves all as it is."""
    values: Mapping[str, Mapping[tuple[str, int], float]] = field(default_factory=dict)
    """The metrics by graph and seed; a run in which a metric is not defined is missing."""
    refused: str = ""
    """Why a stage refuses these parameters; empty where it was run."""

    def mean(self, metric: str) -> float | None:
        """Return the mean over graphs of the mean over worlds; None where no run has the metric."""
        of_graph: dict[str, list[float]] = {}
        for (graph, _), value in self.values.get(metric, {}).items():
            of_graph.setdefault(graph, []).append(value)
        means = [math.fsum(found) / len(found) for found in of_graph.values()]
        return math.fsum(means) / len(means) if means else None


def in_order(trials: Iterable[Trial], metrics: Mapping[str, Better]) -> list[Trial]:
    """Return trials from the best to the worst: by the first metric, equal ones by the next, then by number.

    A trial that was refused, or has no value of a metric, comes behind those that have one.
    """
    return sorted(trials, key=lambda trial: (*(_badness(trial, *item) for item in metrics.items()), trial.number))


def ranks(trials: Sequence[Trial], metrics: Mapping[str, Better]) -> list[float]:
    """Return how many trials each one is better than, for a sampler: it sees an order, not the size of metrics."""
    keys = [tuple(_badness(trial, *item) for item in metrics.items()) for trial in trials]
    return [float(sum(other > key for other in keys)) for key in keys]


def _badness(trial: Trial, metric: str, better: Better) -> float:
    mean = trial.mean(metric)
    if mean is None:
        return math.inf
    return mean if better == "lower" else -mean
