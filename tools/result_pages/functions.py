"""Functions of the results that an expression may call: counts, means, intervals, whether a difference is clear."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from graphnav.ablation.results.statistics import difference_interval, mean_interval
from graphnav.arrays import Doubles
from result_pages.shipped_results import Cell, ShippedResults

SUCCESS = "drive.success"


def worlds(results: ShippedResults, graph: str, variant: str, *, at: str = "") -> int:
    """Return in how many worlds a variant was run."""
    return len(results.runs(Cell(graph, variant, at)))


def arrive(results: ShippedResults, graph: str, variant: str, *, at: str = "") -> int:
    """Return in how many worlds it arrived."""
    return sum(value == 1.0 for value in results.values(Cell(graph, variant, at), SUCCESS).values())


def outcomes(results: ShippedResults, graph: str, variant: str, outcome: str, *, at: str = "") -> int:
    """Return how many drives ended so: goal, contact, timeout, end, failed."""
    return sum(row["outcome"] == outcome for row in results.runs(Cell(graph, variant, at)))


def mean(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "") -> float:
    """Return the mean over the worlds that have a metric."""
    return float(_values(results, graph, variant, metric, at).mean())


def low(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "") -> float:
    """Return the lower end of the mean's 95 % interval."""
    values = _values(results, graph, variant, metric, at)
    return mean_interval(values, is_binary=_is_binary(values)).low


def high(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "") -> float:
    """Return the upper end of the mean's 95 % interval."""
    values = _values(results, graph, variant, metric, at)
    return mean_interval(values, is_binary=_is_binary(values)).high


def difference(results: ShippedResults, graph: str, a: str, b: str, metric: str, *, at: str = "") -> float:
    """Return the mean of ``a - b`` over the worlds that both have."""
    first, second = results.paired(Cell(graph, a, at), Cell(graph, b, at), metric)
    return float((first - second).mean())


def alike(results: ShippedResults, graph: str, a: str, b: str, metric: str = SUCCESS, *, at: str = "") -> int:
    """Return in how many worlds two variants have the same value."""
    first, second = results.paired(Cell(graph, a, at), Cell(graph, b, at), metric)
    return int((first == second).sum())


def clear(results: ShippedResults, graph: str, a: str, b: str, metric: str = SUCCESS, *, at: str = "") -> bool:
    """Return whether the 95 % interval of ``a - b`` leaves out 0; not corrected for several comparisons."""
    first, second = results.paired(Cell(graph, a, at), Cell(graph, b, at), metric)
    interval = difference_interval(first, second, is_binary=_is_binary(first) and _is_binary(second))
    return bool(interval.low > 0 or interval.high < 0)


def graphs_where_clear(results: ShippedResults, a: str, b: str, metric: str = SUCCESS) -> int:
    """Return on how many graphs ``a`` has a clearly higher value than ``b``."""
    return sum(
        clear(results, graph, a, b, metric) and difference(results, graph, a, b, metric) > 0 for graph in results.graphs
    )


def n_graphs(results: ShippedResults) -> int:
    """Return the number of graphs."""
    return len(results.graphs)


def n_runs(results: ShippedResults) -> int:
    """Return the number of runs."""
    return len(results.rows)


def rounded(_: ShippedResults, value: float, digits: int) -> float:
    """Return a value as it is printed."""
    return round(value, digits)


def _values(results: ShippedResults, graph: str, variant: str, metric: str, at: str) -> Doubles:
    return np.array(list(results.values(Cell(graph, variant, at), metric).values()))


def _is_binary(values: Doubles) -> bool:
    return bool(np.isin(values, (0.0, 1.0)).all())


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "worlds": worlds,
    "arrive": arrive,
    "outcomes": outcomes,
    "mean": mean,
    "low": low,
    "high": high,
    "difference": difference,
    "alike": alike,
    "clear": clear,
    "graphs_where_clear": graphs_where_clear,
    "n_graphs": n_graphs,
    "n_runs": n_runs,
    "round": rounded,
}
