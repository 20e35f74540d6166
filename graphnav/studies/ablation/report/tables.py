"""The tables of a study, of two side by side, and of pairs of variants, whatever shows them."""

from __future__ import annotations

from collections.abc import Sequence

from graphnav.core.stage import Better
from graphnav.core.tables import Cell, Column, Table, Tone
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.legend import OWN_FRAMES, marks, outcome_counts, worlds_text
from graphnav.studies.ablation.report.number_format import difference_text, estimate_text
from graphnav.studies.ablation.results import Comparison, Contrast, Difference, Estimate, PairedRow, PairedStudies, Row

_ARROWS: dict[Better, str] = {"higher": " ↑", "lower": " ↓", "neither": ""}


def comparison_table(plan: Plan, comparison: Comparison, graph: str, metrics: Sequence[str]) -> Table:
    """Return the variants on a graph: worlds, outcomes, and each metric with its difference from the base.

    Without the variants that are the same graph as another.
    """
    columns = [Column("variant"), Column("worlds"), Column("outcomes")]
    for metric in metrics:
        name = metric_heading(plan, metric)
        columns += [Column(name, name), Column("difference", name)]
    rows = [_cells(row, metrics, plan) for row in comparison.of_graph(graph) if not row.case.same_as]
    return Table(columns, rows, graph)


def paired_table(pairing: PairedStudies, graph: str, metrics: Sequence[str], *, has_outcomes: bool) -> Table:
    """Return the variants of two studies on a graph: each metric in both, and the difference of the second."""
    columns = [Column("variant"), Column("worlds")]
    columns += [Column("outcomes of A"), Column("outcomes of B")] if has_outcomes else []
    for metric in metrics:
        name = metric_heading(pairing.plan_of(metric), metric)
        columns += [Column(f"{name} A", name), Column("B", name), Column("B - A", name)]
    rows = [
        _paired_cells(row, metrics, pairing, has_outcomes=has_outcomes) for row in pairing.rows if row.graph == graph
    ]
    return Table(columns, rows, graph, n_fixed=2)


def contrast_table(pair: Contrast, plan: Plan) -> Table:
    """Return two variants on a graph: every metric of both, with the difference; no rows if none is compared."""
    columns = [Column("metric"), *(Column(name, name) for name in ("A", "B", "A - B", "A better with"))]
    rows = [_contrast_cells(pair, metric, plan) for metric in pair.differences if metric in pair.estimates]
    return Table(columns, rows, f"{pair.graph}: {pair.first} (A), {pair.second} (B)")


def metric_heading(plan: Plan, metric: str) -> str:
    """Return the label of a metric, with an arrow to its better side."""
    return f"{plan.label(metric)}{_ARROWS[plan.better(metric)]}"


def _cells(row: Row, metrics: Sequence[str], plan: Plan) -> list[Cell]:
    cells = [
        Cell(row.case.variant, "strong" if row.case.is_base else "", marks(row)),
        Cell(worlds_text(row)),
        Cell(outcome_counts(row.outcomes)),
    ]
    for metric in metrics:
        cells.append(_mean(row.estimates.get(metric), row.runs))
        cells.append(_change(row, metric, plan.better(metric)))
    return cells


def _paired_cells(row: PairedRow, metrics: Sequence[str], pairing: PairedStudies, *, has_outcomes: bool) -> list[Cell]:
    n_worlds = len(row.seeds)
    cells = [Cell(row.variant), Cell(str(n_worlds))]
    cells += [Cell(outcome_counts(of)) for of in (row.outcomes_a, row.outcomes_b)] if has_outcomes else []
    for metric in metrics:
        cells += [_mean(side.get(metric), n_worlds) for side in (row.estimates_a, row.estimates_b)]
        cells.append(_change(row, metric, pairing.metrics[metric]))
    return cells


def _contrast_cells(pair: Contrast, metric: str, plan: Plan) -> list[Cell]:
    difference, better = pair.differences[metric], plan.better(metric)
    chance = difference.probability_better
    worlds = [plan.n_worlds(plan.case(pair.graph, variant)) for variant in (pair.first, pair.second)]
    return [
        Cell(metric_heading(plan, metric)),
        *(_mean(found, n) for found, n in zip(pair.estimates[metric], worlds, strict=True)),
        _difference(difference, better),
        Cell("" if better == "neither" else estimate_text(chance, chance.n)),
    ]


def _mean(found: Estimate | None, n_worlds: int) -> Cell:
    return Cell("" if found is None else estimate_text(found, n_worlds))


def _change(row: Row | PairedRow, metric: str, better: Better) -> Cell:
    return Cell(OWN_FRAMES, "quiet") if metric in row.own_frames else _difference(row.differences.get(metric), better)


def _difference(found: Difference | None, better: Better) -> Cell:
    """Return a difference, which stands out where it is clear."""
    if found is None:
        return Cell()
    tone: Tone = ""
    if found.is_clear:
        tone = "clear" if better == "neither" else "good" if (found.low > 0) == (better == "higher") else "bad"
    return Cell(difference_text(found), tone, is_markdown=True)
