"""Short tables of studies for the terminal."""

from __future__ import annotations

from collections.abc import Iterable

from rich.text import Text

from graphnav.core.machine import Console
from graphnav.core.tables import print_fitted
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.legend import OWN_FRAMES, same_graphs, too_few_worlds
from graphnav.studies.ablation.report.markdown import different_versions, only_in_one
from graphnav.studies.ablation.report.tables import comparison_table, contrast_table, paired_table
from graphnav.studies.ablation.results import Comparison, Contrast, PairedStudies, shown_metrics

DECIDING = 2
"""Metrics that the terminal shows; `table.md` has them all."""


def print_comparison(console: Console, comparison: Comparison, plan: Plan) -> None:
    """Print, graph by graph, the outcomes of each variant and its deciding metrics."""
    metrics = shown_metrics(plan, comparison)[:DECIDING]
    for graph in plan.graphs:
        print_fitted(console, comparison_table(plan, comparison, graph, metrics))
        rows = comparison.of_graph(graph)
        for line in same_graphs(rows):
            console.print(Text(line, style="dim"), soft_wrap=True)
        for row in rows:
            for reason, times in row.failures.items() if not row.case.same_as else ():
                line = " ".join(f"{row.case.variant}: {times} failed: {reason}".split())
                console.print(Text(line, style="red"), soft_wrap=True)
    if few := too_few_worlds(plan, comparison):
        console.print(Text(few, style="yellow"), soft_wrap=True)


def print_paired_studies(console: Console, pairing: PairedStudies) -> None:
    """Print how each variant changed from the first study to the second, and what cannot be compared."""
    metrics = tuple(pairing.metrics)[:DECIDING]
    for graph in pairing.graphs:
        print_fitted(console, paired_table(pairing, graph, metrics, has_outcomes=False))
    for line in (*only_in_one(pairing), *different_versions(pairing)):
        console.print(Text(line, style="yellow"), soft_wrap=True)


def print_contrasts(console: Console, found: Iterable[Contrast], plan: Plan) -> None:
    """Print pairs of variants, graph by graph: every metric of both, with the difference."""
    for pair in found:
        table = contrast_table(pair, plan)
        if table.rows:
            print_fitted(console, table)
        else:
            own = any(metric in pair.estimates for metric in plan.metrics)
            why = f"not compared: {OWN_FRAMES}" if own else "no world has runs of both"
            console.print(Text(f"{table.title}: {why}", style="yellow"), soft_wrap=True)
