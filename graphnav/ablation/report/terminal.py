"""Short tables of studies for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from graphnav.ablation.plan import Plan
from graphnav.ablation.report.legend import marks, outcome_counts, same_graphs, worlds_text
from graphnav.ablation.report.markdown import ARROWS
from graphnav.ablation.report.number_format import difference_text, estimate_text
from graphnav.ablation.report.paired_markdown import different_versions, only_in_one
from graphnav.ablation.results import Comparison, Difference, PairedRow, PairedStudies, Row, shown_metrics
from graphnav.stage import Better

DECIDING = 2
"""Metrics that the terminal shows; `table.md` has them all."""
_MAX_COLS = 1000
"""Tables are as wide as they need: a narrow terminal wraps them, because a number that is cut would be a wrong one."""


def print_comparison(console: Console, comparison: Comparison, plan: Plan) -> None:
    """Print, graph by graph, the outcomes of each variant and its deciding metrics."""
    metrics = shown_metrics(plan, comparison)[:DECIDING]
    for graph in plan.graphs:
        rows = [row for row in comparison.of_graph(graph) if not row.case.same_as]
        table = new_table(graph, ["variant", "worlds", "outcomes"])
        for metric in metrics:
            table.add_column(Text(f"{plan.label(metric)}{ARROWS[plan.better(metric)]}"))
            table.add_column("difference")
        for row in rows:
            table.add_row(*_cells(row, metrics, plan))
        print_wide(console, table)
        for line in same_graphs(comparison.of_graph(graph)):
            console.print(Text(line, style="dim"), soft_wrap=True)
        for row in rows:
            for reason, times in row.failures.items():
                line = " ".join(f"{row.case.variant}: {times} failed: {reason}".split())
                console.print(Text(line, style="red"), soft_wrap=True)


def print_paired_studies(console: Console, pairing: PairedStudies) -> None:
    """Print how each variant changed from the first study to the second, and what cannot be compared."""
    metrics = tuple(pairing.metrics)[:DECIDING]
    for graph in pairing.graphs:
        table = new_table(graph, ["variant", "worlds"])
        for metric in metrics:
            for name in (f"{pairing.plan_of(metric).label(metric)}{ARROWS[pairing.metrics[metric]]} A", "B", "B - A"):
                table.add_column(Text(name))
        for row in pairing.rows:
            if row.graph == graph:
                table.add_row(*_pair_cells(row, metrics, pairing))
        print_wide(console, table)
    for line in (*only_in_one(pairing), *different_versions(pairing)):
        console.print(Text(line, style="yellow"), soft_wrap=True)


def new_table(title: str, columns: Sequence[str]) -> Table:
    """Return an empty table."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=Text(title, style="bold"), title_justify="left")
    for name in columns:
        table.add_column(name)
    return table


def print_wide(console: Console, table: Table) -> None:
    """Print a table as wide as it needs."""
    table.width = Measurement.get(console, console.options.update(width=_MAX_COLS), table).maximum
    console.print(table, soft_wrap=True)


def difference_cell(found: Difference | None, better: Better) -> Text:
    """Return a difference, green or red where it is clear which is better."""
    if found is None:
        return Text()
    if not found.is_clear or better == "neither":
        return Text(difference_text(found))
    return Text(difference_text(found), style="green" if (found.low > 0) == (better == "higher") else "red")


def _cells(row: Row, metrics: Sequence[str], plan: Plan) -> list[Text]:
    name = Text(row.case.variant, style="bold" if row.case.is_base else "")
    name.append("".join(f" ({mark})" for mark in marks(row)), style="dim not bold")
    cells = [name, Text(worlds_text(row, plan)), Text(outcome_counts(row.outcomes))]
    for metric in metrics:
        found = row.estimates.get(metric)
        cells.append(Text("" if found is None else estimate_text(found, row.runs)))
        cells.append(difference_cell(row.differences.get(metric), plan.better(metric)))
    return cells


def _pair_cells(row: PairedRow, metrics: Sequence[str], pairing: PairedStudies) -> list[Text]:
    cells = [Text(row.variant), Text(str(len(row.seeds)))]
    for metric in metrics:
        sides = (row.estimates_a, row.estimates_b)
        cells += [Text(estimate_text(side[metric], len(row.seeds)) if metric in side else "") for side in sides]
        cells.append(difference_cell(row.differences.get(metric), pairing.metrics[metric]))
    return cells
