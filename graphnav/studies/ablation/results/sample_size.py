"""About how many worlds a study would need to tell a difference of the size that it found."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from statistics import NormalDist

import numpy as np

from graphnav.arrays import Doubles
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.results.comparison import Comparison, Difference
from graphnav.studies.ablation.results.records import Record, are_cut_off, in_plan_order
from graphnav.studies.ablation.results.statistics import ALPHA, min_worlds
from graphnav.studies.ablation.results.study_values import is_binary, paired_differences, values_of
from graphnav.studies.ablation.study import MetricExpression

POWER = 0.8
"""Share of studies of that many worlds which would find the difference clear."""
MAX_WORLDS = 10_000
"""A difference that needs more is practically none."""


_CUT_OFF = "every run hit the time limit before it arrived, which shows nothing: --set run.until_s=SECONDS"


def worlds_needed(differences: Doubles, *, binary: bool, comparisons: int = 1) -> int | None:
    """Return the number of worlds at which 4 of 5 studies would find a difference of this mean and spread clear.

    ``differences``: paired, one a world, at least two. ``binary``: whether they are of a metric that is 0 or 1, so that
    the share of worlds that differ gives the spread under no difference, as for McNemar's test [Connor]; else by the
    formula of the t test [Guenther]. ``comparisons`` share the level. None where the mean is 0,
    or more than `MAX_WORLDS` are needed.

    References
    ----------
    .. [Connor] R. J. Connor, Sample Size for Testing Differences in Proportions for the Paired-Sample Design,
       Biometrics 43(1), 1987.
    .. [Guenther] W. C. Guenther, Sample Size Formulas for Normal Theory T Tests, The American Statistician 35(4), 1981.
    """
    mean = abs(float(differences.mean()))
    if mean == 0:
        return None
    level, power = NormalDist().inv_cdf(1 - ALPHA / comparisons / 2), NormalDist().inv_cdf(POWER)
    if binary:
        discordant = float(np.count_nonzero(differences)) / differences.size
        spread = level * math.sqrt(discordant) + power * math.sqrt(discordant - mean**2)
        worlds = (spread / mean) ** 2
    else:
        worlds = ((level + power) * float(differences.std(ddof=1)) / mean) ** 2 + level**2 / 2
    return max(math.ceil(worlds), min_worlds(comparisons)) if worlds <= MAX_WORLDS else None


def sample_size_texts(plan: Plan, comparison: Comparison, records: Sequence[Record]) -> Iterator[str]:
    """Yield sentences on the variants that the metric that decides does not tell from the base.

    Variants of a graph with the same sentence share it. Nothing for a study that its results stop: the numbers are for
    tests of as many worlds as were set before.
    """
    if comparison.primary is None or plan.until_clear:
        return
    column = MetricExpression.parse(comparison.primary)
    runs: dict[tuple[str, str], list[Record]] = {}
    for record in in_plan_order(plan, records):
        runs.setdefault((record.graph, record.variant), []).append(record)
    values = {key: values_of(plan, column, found) for key, found in runs.items()}
    binary = is_binary(plan, column, values.values())
    for graph in plan.graphs:
        rows = [row for row in comparison.of_graph(graph) if column.text in row.differences and not row.case.same_as]
        base = next(case.variant for case in plan.cases if case.graph == graph and case.is_base)
        variants: dict[tuple[int, str], list[str]] = {}
        for row in rows:
            found = row.differences[column.text]
            if found.is_clear or found.n < 2 or found.significance is None:
                continue
            differences = paired_differences(values[graph, row.case.variant], values[graph, base])
            needed = worlds_needed(differences, binary=binary, comparisons=found.significance.family)
            both = runs[graph, row.case.variant] + runs[graph, base]
            is_cut_off = are_cut_off(plan, both) and not plan.is_of_frames(column.text)
            needs = _CUT_OFF if is_cut_off else _needs(needed, found)
            variants.setdefault((found.n, needs), []).append(row.case.variant)
        for (n, needs), names in variants.items():
            yield f"{graph}, {', '.join(names)}: {column.text} is not clear after {n} worlds; {needs}"


def _needs(worlds: int | None, found: Difference) -> str:
    if found.mean == 0:
        return "they show no difference"
    if not found.matters:
        return f"the difference is smaller than {found.min_difference:g}, the smallest that matters"
    if worlds is None:
        return f"a difference this small needs more than {MAX_WORLDS}"
    return f"a difference of this size would be clear in 4 of 5 studies of about {worlds}"
