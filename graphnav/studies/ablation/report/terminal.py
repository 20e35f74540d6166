"""Short tables of studies for the terminal."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from graphnav.core.machine.console import Console
from graphnav.core.machine.fitted_tables import fitted_tables
from graphnav.core.stage import Better
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.legend import (
    OWN_FRAMES,
    marks,
    outcome_counts,
    same_graphs,
    too_few_worlds,
    worlds_text,
)
from graphnav.studies.ablation.report.markdown import ARROWS, different_versions, only_in_one
from graphnav.studies.ablation.report.number_format import difference_text, estimate_text
from graphnav.studies.ablation.results import (
    Comparison,
    Contrast,
    Difference,
    PairedRow,
    PairedStudies,
    Row,
    shown_metrics,
)

DECIDING = 2
"""Metrics that the terminal shows; `table.md` has them all."""


def print_comparison(console: Console, comparison: Comparison, plan: Plan) -> None:
    """Print, graph by graph, the outcomes of each variant and its deciding metrics."""
    metrics = shown_metrics(plan, comparison)[:DECIDING]
    for graph in plan.graphs:
        rows = [row for row in comparison.of_graph(graph) if not row.case.same_as]
        groups = {"": ["worlds", "outcomes"], **{(of := _heading(plan, name)): [of, "difference"] for name in metrics}}
        print_grouped(console, graph, ["variant"], groups, [_cells(row, metrics, plan) for row in rows])
        for line in same_graphs(comparison.of_graph(graph)):
            console.print(Text(line, style="dim"), soft_wrap=True)
        for row in rows:
            for reason, times in row.failures.items():
                line = " ".join(f"{row.case.variant}: {times} failed: {reason}".split())
                console.print(Text(line, style="red"), soft_wrap=True)
    if few := too_few_worlds(plan, comparison):
        console.print(Text(few, style="yellow"), soft_wrap=True)


def print_paired_studies(console: Console, pairing: PairedStudies) -> None:
    """Print how each variant changed from the first study to the second, and what cannot be compared."""
    metrics = tuple(pairing.metrics)[:DECIDING]
    for graph in pairing.graphs:
        groups = {(of := _heading(pairing.plan_of(name), name)): [f"{of} A", "B", "B - A"] for name in metrics}
        rows = [_pair_cells(row, metrics, pairing) for row in pairing.rows if row.graph == graph]
        print_grouped(console, graph, ["variant", "worlds"], groups, rows)
    for line in (*only_in_one(pairing), *different_versions(pairing)):
        console.print(Text(line, style="yellow"), soft_wrap=True)


def print_contrasts(console: Console, found: Iterable[Contrast], plan: Plan) -> None:
    """Print pairs of variants, graph by graph: every metric of both, with the difference."""
    columns = ["metric", "A", "B", "A - B", "A better with"]
    for pair in found:
        title = f"{pair.graph}: {pair.first} (A), {pair.second} (B)"
        rows = [_contrast_cells(pair, metric, plan) for metric in pair.differences if metric in pair.estimates]
        if rows:
            print_grouped(console, title, columns, {}, rows)
        else:
            own = any(metric in pair.estimates for metric in plan.metrics)
            why = f"not compared: {OWN_FRAMES}" if own else "no world has runs of both"
            console.print(Text(f"{title}: {why}", style="yellow"), soft_wrap=True)


def _contrast_cells(pair: Contrast, metric: str, plan: Plan) -> list[Text]:
    difference = pair.differences[metric]
    chance = difference.probability_better
    worlds = [plan.n_worlds(plan.case(pair.graph, variant)) for variant in (pair.first, pair.second)]
    return [
        Text(_heading(plan, metric)),
        *(Text(estimate_text(found, n)) for found, n in zip(pair.estimates[metric], worlds, strict=True)),
        difference_cell(difference, plan.better(metric)),
        Text("" if plan.better(metric) == "neither" else estimate_text(chance, chance.n)),
    ]


def _table(title: str, columns: Sequence[str], rows: Sequence[Sequence[Text]]) -> Table:
    shown = Text(title, style="bold") if title else None
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title=shown, title_justify="left")
    for name in columns:
        table.add_column(Text(name))
    for row in rows:
        table.add_row(*row)
    return table


def print_grouped(
    console: Console,
    title: str,
    names: Sequence[str],
    groups: Mapping[str, Sequence[str]],
    rows: Sequence[Sequence[Text]],
) -> None:
    """Print a table whose columns are ``names`` and those of all groups, in blocks that fit the terminal.

    ``rows``: cells in the order of the columns. Without groups each column behind the first stands for itself.
    """
    columns = [*names, *(column for group in groups.values() for column in group)]
    table, sizes = _table(title, columns, rows), {name: len(group) for name, group in groups.items()}
    for block in fitted_tables(console, table, fixed=len(names) if groups else 1, groups=sizes):
        console.print(block, soft_wrap=True)


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
    cells = [name, Text(worlds_text(row)), Text(outcome_counts(row.outcomes))]
    for metric in metrics:
        found = row.estimates.get(metric)
        cells.append(Text("" if found is None else estimate_text(found, row.runs)))
        change = difference_cell(row.differences.get(metric), plan.better(metric))
        cells.append(Text(OWN_FRAMES, style="dim") if metric in row.own_frames else change)
    return cells


def _pair_cells(row: PairedRow, metrics: Sequence[str], pairing: PairedStudies) -> list[Text]:
    cells = [Text(row.variant), Text(str(len(row.seeds)))]
    for metric in metrics:
        sides = (row.estimates_a, row.estimates_b)
        cells += [Text(estimate_text(side[metric], len(row.seeds)) if metric in side else "") for side in sides]
        change = difference_cell(row.differences.get(metric), pairing.metrics[metric])
        cells.append(Text(OWN_FRAMES, style="dim") if metric in row.own_frames else change)
    return cells


def _heading(plan: Plan, metric: str) -> str:
    return f"{plan.label(metric)}{ARROWS[plan.better(metric)]}"
