"""Functions of the results that an expression may call: counts, means, intervals, whether a difference is clear."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from graphnav.arrays import Doubles
from graphnav.core.errors import UserError
from graphnav.studies.ablation.results.comparison import Difference, as_family
from graphnav.studies.ablation.results.statistics import ALPHA, Interval, mean_interval
from graphnav.studies.ablation.results.study_values import difference as of_worlds
from result_pages.shipped_results import Cell, NotMeasuredError, ShippedResults

SUCCESS = "drive.success"
_MAX_SEEDS = 1 << 32


def worlds(results: ShippedResults, graph: str, variant: str, *, at: str = "") -> int:
    """Return in how many worlds a variant was run."""
    return len(results.runs(Cell(graph, variant, at)))


def arrive(results: ShippedResults, graph: str, variant: str, *, at: str = "") -> int:
    """Return in how many worlds it arrived."""
    return sum(value == 1.0 for value in results.values(Cell(graph, variant, at), SUCCESS).values())


def arrivals(results: ShippedResults, graph: str, variant: str) -> str:
    """Return in how many worlds it arrived under each condition, in their order."""
    return " / ".join(str(arrive(results, graph, variant, at=at)) for at in results.conditions(graph))


def outcomes(results: ShippedResults, graph: str, variant: str, outcome: str, *, at: str = "") -> int:
    """Return how many drives ended so: goal, contact, timeout, end, failed."""
    return sum(row["outcome"] == outcome for row in results.runs(Cell(graph, variant, at)))


def mean(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "") -> float:
    """Return the mean over the worlds that have a metric."""
    return float(_values(results, graph, variant, metric, at).mean())


def total(
    results: ShippedResults,
    graph: str,
    variant: str,
    metric: str,
    *,
    at: str = "",
    first: int = 0,
    last: int = _MAX_SEEDS,
) -> float:
    """Return the sum over the worlds that have a metric, from seed to seed: of one that is 0 or 1, how many."""
    return sum(value for seed, value in _by_seed(results, graph, variant, metric, at).items() if first <= seed <= last)


def lowest(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "") -> float:
    """Return the lowest value over the worlds that have a metric."""
    return float(_values(results, graph, variant, metric, at).min())


def low(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "", modulo: int = 0) -> float:
    """Return the lower end of the mean's 95 % interval; ``modulo``: see `interval`."""
    return _mean(results, graph, variant, metric, at, modulo)[1].low


def high(results: ShippedResults, graph: str, variant: str, metric: str, *, at: str = "", modulo: int = 0) -> float:
    """Return the upper end of the mean's 95 % interval; ``modulo``: see `interval`."""
    return _mean(results, graph, variant, metric, at, modulo)[1].high


def interval(
    results: ShippedResults,
    graph: str,
    variant: str,
    metric: str,
    digits: int,
    *,
    at: str = "",
    modulo: int = 0,
    maximum: float = math.inf,
) -> str:
    """Return the mean with its 95 % interval as they are printed.

    ``modulo``: seeds that are equal modulo this were run in one world; the means of the worlds are the samples.
    ``maximum``: of the metric, beyond which no interval reaches.
    """
    middle, ends = _mean(results, graph, variant, metric, at, modulo)
    return f"{middle:.{digits}f} [{ends.low:.{digits}f}, {min(ends.high, maximum):.{digits}f}]"


def difference(results: ShippedResults, graph: str, a: str, b: str, metric: str, *, at: str = "") -> float:
    """Return the mean of ``a - b`` over the worlds that both have."""
    cell, other = Cell(graph, a, at), Cell(graph, b, at)
    first, second = results.paired(cell, other, metric)
    if not first.size:
        raise _nothing_in_common(cell, other, metric)
    return float((first - second).mean())


def alike(results: ShippedResults, graph: str, a: str, b: str, metric: str = SUCCESS, *, at: str = "") -> int:
    """Return in how many worlds two variants have the same value."""
    first, second = results.paired(Cell(graph, a, at), Cell(graph, b, at), metric)
    return int((first == second).sum())


def apart(results: ShippedResults, graph: str, a: str, b: str, metric: str = SUCCESS, *, at: str = "") -> bool:
    """Return whether two variants are told apart, as the only question asked: p at most 0.05, and what matters."""
    return _is_apart(_difference(results, Cell(graph, a, at), Cell(graph, b, at), metric))


def change(
    results: ShippedResults,
    graph: str,
    variant: str,
    metric: str,
    digits: int,
    *,
    at: str,
    since: str,
    modulo: int = 0,
) -> str:
    """Return by how much a variant's metric is higher under one condition than under another, as it is printed.

    With its 95 % interval; ``modulo``: see `interval`.
    """
    return _shown(_change(results, graph, variant, metric, at, since, modulo), digits)


def changes(
    results: ShippedResults, graph: str, variant: str, metric: str, *, at: str, since: str, modulo: int = 0
) -> bool:
    """Return whether a variant is told apart from itself under another condition, as the only question asked."""
    return _is_apart(_change(results, graph, variant, metric, at, since, modulo))


def unchanged(results: ShippedResults, graph: str, variant: str, metric: str = SUCCESS, *, at: str, since: str) -> int:
    """Return in how many worlds a variant has the same value under two conditions."""
    first, second = results.paired(Cell(graph, variant, at), Cell(graph, variant, since), metric)
    return int((first == second).sum())


def clear(results: ShippedResults, graph: str, variant: str, metric: str = SUCCESS, *, at: str = "") -> bool:
    """Return whether a variant differs from the base as the bold ones of ``table.md`` do, with all others considered.

    The base is the first variant. Variants with the same runs are one of the family.
    """
    base = Cell(graph, results.variants[0], at)
    cells = {results.measured(cell): cell for cell in results.cells(graph, at)}
    cells.pop(results.measured(base))
    found = [_difference(results, cell, base, metric) for cell in cells.values()]
    judged = dict(zip(cells, as_family(found, len(found)), strict=True))
    return judged[results.measured(Cell(graph, variant, at))].is_clear


def ahead(results: ShippedResults, graph: str, variant: str, a: str, b: str, *, at: str = "") -> bool:
    """Return whether one metric of a variant's runs is above another, world by world: p at most 0.05, as one question.

    So are detectors compared that look at the same frames, each with a score of its own.
    """
    cell = Cell(graph, variant, at)
    this, that = results.values(cell, a), results.values(cell, b)
    found = of_worlds(this, that, "higher", is_binary=False)
    return found is not None and found.p <= ALPHA and found.low > 0


def graphs_above(results: ShippedResults, variant: str, metric: str = SUCCESS) -> int:
    """Return on how many graphs a variant has a clearly higher value than the base."""
    return _graphs_where(results, variant, metric, 1)


def graphs_below(results: ShippedResults, variant: str, metric: str = SUCCESS) -> int:
    """Return on how many graphs a variant has a clearly lower value than the base."""
    return _graphs_where(results, variant, metric, -1)


def graphs_apart(results: ShippedResults, a: str, b: str, metric: str = SUCCESS) -> int:
    """Return on how many graphs two variants are told apart."""
    return len(where_apart(results, a, b, metric))


def where_apart(results: ShippedResults, a: str, b: str, metric: str) -> list[str]:
    """Return the graphs that have a metric and on which two variants are told apart."""
    measured = [graph for graph in results.graphs if results.values(Cell(graph, b), metric)]
    return [graph for graph in measured if apart(results, graph, a, b, metric)]


def graphs_alike(results: ShippedResults, a: str, b: str, metric: str = SUCCESS) -> int:
    """Return on how many graphs two variants have the same value in every world."""
    return sum(alike(results, graph, a, b, metric) == worlds(results, graph, a) for graph in results.graphs)


def arrive_of_all(results: ShippedResults, variant: str, *, at: str = "") -> int:
    """Return how many drives of a variant arrived, on all graphs."""
    return sum(arrive(results, graph, variant, at=at) for graph in results.graphs)


def runs_of(results: ShippedResults, variant: str, *, at: str = "") -> int:
    """Return how many drives a variant made, on all graphs."""
    return sum(worlds(results, graph, variant, at=at) for graph in results.graphs)


def change_of_all(results: ShippedResults, variant: str, metric: str, digits: int, *, at: str, since: str) -> str:
    """Return `change` over the worlds of all graphs."""
    return _shown(_of_all(results, (variant, at), (variant, since), metric), digits)


def changes_of_all(results: ShippedResults, variant: str, metric: str, *, at: str, since: str) -> bool:
    """Return `changes` over the worlds of all graphs."""
    return _is_apart(_of_all(results, (variant, at), (variant, since), metric))


def unchanged_of_all(results: ShippedResults, variant: str, metric: str = SUCCESS, *, at: str, since: str) -> int:
    """Return in how many worlds of all graphs a variant has the same value under two conditions."""
    return sum(unchanged(results, graph, variant, metric, at=at, since=since) for graph in results.graphs)


def difference_of_all(results: ShippedResults, a: str, b: str, metric: str = SUCCESS) -> float:
    """Return the mean of ``a - b`` over the worlds of all graphs."""
    return _of_all(results, (a, ""), (b, ""), metric).mean


def apart_of_all(results: ShippedResults, a: str, b: str, metric: str = SUCCESS) -> bool:
    """Return whether two variants are told apart over the worlds of all graphs, as the only question asked."""
    return _is_apart(_of_all(results, (a, ""), (b, ""), metric))


def n_graphs(results: ShippedResults) -> int:
    """Return the number of graphs."""
    return len(results.graphs)


def n_runs(results: ShippedResults) -> int:
    """Return the number of runs."""
    return len(results.rows)


def rounded(_: ShippedResults, value: float, digits: int) -> float:
    """Return a value as it is printed."""
    return round(value, digits)


def _of_all(results: ShippedResults, a: tuple[str, str], b: tuple[str, str], metric: str) -> Difference:
    """Return how two variants, each under a condition, differ over the worlds of all graphs."""
    this, that = (
        {
            place * _MAX_SEEDS + seed: value
            for place, graph in enumerate(results.graphs)
            for seed, value in results.values(Cell(graph, *one), metric).items()
        }
        for one in (a, b)
    )
    binary = results.is_binary(metric)
    found = of_worlds(this, that, "higher", is_binary=binary, min_difference=results.min_difference(metric))
    if found is None:
        raise NotMeasuredError.of(f"'{a}' and '{b}' have no world in common with '{metric}'", "compare others")
    return found


def _shown(found: Difference, digits: int) -> str:
    return f"{found.mean:+.{digits}f} [{found.low:+.{digits}f}, {found.high:+.{digits}f}]"


def _is_apart(found: Difference) -> bool:
    return bool(found.p <= ALPHA and found.matters and (found.low > 0 or found.high < 0))


def _graphs_where(results: ShippedResults, variant: str, metric: str, sign: int) -> int:
    base = results.variants[0]
    return sum(
        clear(results, graph, variant, metric) and sign * difference(results, graph, variant, base, metric) > 0
        for graph in results.graphs
    )


def _difference(results: ShippedResults, cell: Cell, base: Cell, metric: str) -> Difference:
    this, that = results.values(cell, metric), results.values(base, metric)
    binary = results.is_binary(metric)
    found = of_worlds(this, that, "higher", is_binary=binary, min_difference=results.min_difference(metric))
    if found is None:
        raise _nothing_in_common(cell, base, metric)
    return found


def _change(
    results: ShippedResults, graph: str, variant: str, metric: str, at: str, since: str, modulo: int
) -> Difference:
    now, then = (_by_world(_by_seed(results, graph, variant, metric, one), modulo) for one in (at, since))
    binary = results.is_binary(metric) and not modulo
    found = of_worlds(now, then, "higher", is_binary=binary, min_difference=results.min_difference(metric))
    if found is None:
        raise _nothing_in_common(Cell(graph, variant, at), Cell(graph, variant, since), metric)
    return found


def _nothing_in_common(cell: Cell, other: Cell, metric: str) -> UserError:
    return NotMeasuredError.of(f"{cell} and {other} have no world in common with '{metric}'", "compare others")


def _values(results: ShippedResults, graph: str, variant: str, metric: str, at: str) -> Doubles:
    return np.array(list(_by_seed(results, graph, variant, metric, at).values()))


def _mean(
    results: ShippedResults, graph: str, variant: str, metric: str, at: str, modulo: int
) -> tuple[float, Interval]:
    """Return the mean and its interval; ``modulo``: see `interval`."""
    values = np.array(list(_by_world(_by_seed(results, graph, variant, metric, at), modulo).values()))
    return float(np.mean(values)), mean_interval(values, is_binary=results.is_binary(metric) and not modulo)


def _by_world(by_seed: Mapping[int, float], modulo: int) -> Mapping[int, float]:
    """Return the mean of each world's seeds; ``modulo``: see `interval`."""
    if not modulo:
        return by_seed
    of_world: dict[int, list[float]] = {}
    for seed, value in by_seed.items():
        of_world.setdefault(seed % modulo, []).append(value)
    return {world: float(np.mean(values)) for world, values in of_world.items()}


def _by_seed(results: ShippedResults, graph: str, variant: str, metric: str, at: str) -> Mapping[int, float]:
    found = results.values(Cell(graph, variant, at), metric)
    if not found:
        raise NotMeasuredError.of(f"no run of '{variant}' on '{graph}' has '{metric}'", "name another metric")
    return found


FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "worlds": worlds,
    "arrive": arrive,
    "arrivals": arrivals,
    "outcomes": outcomes,
    "mean": mean,
    "total": total,
    "lowest": lowest,
    "low": low,
    "high": high,
    "interval": interval,
    "difference": difference,
    "alike": alike,
    "apart": apart,
    "change": change,
    "changes": changes,
    "unchanged": unchanged,
    "clear": clear,
    "ahead": ahead,
    "graphs_above": graphs_above,
    "graphs_below": graphs_below,
    "graphs_apart": graphs_apart,
    "graphs_alike": graphs_alike,
    "arrive_of_all": arrive_of_all,
    "runs_of": runs_of,
    "difference_of_all": difference_of_all,
    "apart_of_all": apart_of_all,
    "change_of_all": change_of_all,
    "changes_of_all": changes_of_all,
    "unchanged_of_all": unchanged_of_all,
    "n_graphs": n_graphs,
    "n_runs": n_runs,
    "round": rounded,
}
