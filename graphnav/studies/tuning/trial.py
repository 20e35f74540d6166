"""A trial: the parameters of a rival, and what came of them in every world."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Any

from graphnav.core.stage import Better

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
    failures: Mapping[tuple[str, int], str] = field(default_factory=dict)
    """The causes of failed runs by graph and seed."""

    def mean(self, metric: str) -> float | None:
        """Return the mean over graphs of the mean over worlds; None where no run has the metric."""
        of_graph: dict[str, list[float]] = {}
        for (graph, _), value in self.values.get(metric, {}).items():
            of_graph.setdefault(graph, []).append(value)
        means = [math.fsum(found) / len(found) for found in of_graph.values()]
        return math.fsum(means) / len(means) if means else None

    def n_runs(self, metric: str) -> int:
        """Return how many runs have the metric."""
        return len(self.values.get(metric, {}))


def in_order(trials: Sequence[Trial], metrics: Mapping[str, Better], like: Sequence[Trial]) -> list[Trial]:
    """Return trials from the best to the worst: by the first metric, equal ones by the next, then as they were.

    A trial that has a metric in fewer runs than one of ``like`` comes behind those that have it in as many, whatever
    its mean: it is the mean of the runs that did not fail.
    """
    return sorted(trials, key=lambda trial: _badness(trial, metrics, like))


def in_ranks(trials: Sequence[Trial], metrics: Mapping[str, Better]) -> list[list[Trial]]:
    """Return trials `in_order`, compared with each other; those that are equal in all metrics share a rank."""
    ordered = in_order(trials, metrics, trials)
    return [list(equal) for _, equal in groupby(ordered, lambda trial: _badness(trial, metrics, trials))]


def ranks(trials: Sequence[Trial], metrics: Mapping[str, Better]) -> list[float]:
    """Return how many trials each one is better than, for a sampler: it sees an order, not the size of metrics.

    The first of ``trials`` is the default, as `in_order` takes it.
    """
    keys = [_badness(trial, metrics, trials[:1]) for trial in trials]
    return [float(sum(other > key for other in keys)) for key in keys]


def _badness(trial: Trial, metrics: Mapping[str, Better], like: Sequence[Trial]) -> tuple[tuple[float, float], ...]:
    return tuple(_badness_in(trial, metric, better, like) for metric, better in metrics.items())


def _badness_in(trial: Trial, metric: str, better: Better, like: Sequence[Trial]) -> tuple[float, float]:
    """Return the number of missing runs and the mean, both lower for better trials."""
    mean = trial.mean(metric)
    if mean is None:
        return math.inf, math.inf
    own, wanted = trial.n_runs(metric), max(one.n_runs(metric) for one in like)
    return max(wanted - own, 0) if wanted else -own, mean if better == "lower" else -mean
