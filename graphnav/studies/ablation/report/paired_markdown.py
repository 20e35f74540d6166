"""Two studies side by side in Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from graphnav.studies.ablation.report.legend import (
    INTERVALS,
    OWN_FRAMES,
    TESTS,
    UNTESTED,
    counting,
    deciding,
    origin,
    outcome_counts,
    seeds_text,
)
from graphnav.studies.ablation.report.markdown import (
    ARROWS,
    METRICS_PER_TABLE,
    bullets,
    code,
    difference_cell,
    document,
    escaped,
    table,
)
from graphnav.studies.ablation.report.number_format import estimate_text
from graphnav.studies.ablation.results import PairedRow, PairedStudies

READING = (
    "A is the first study, B the second. Each cell is the mean over the worlds that both have, with its interval; ↑ "
    "higher is better, ↓ lower. B - A is the mean difference in the same worlds with its interval, then in how many of "
    "them B was better–alike–worse."
)

_OWN_FRAMES = (
    f"{OWN_FRAMES.capitalize()}: the plans do not show that the drive is the same in both, with the same parameters, "
    "code and versions, so the runs may have met other frames; what depends on these is not compared."
)


def paired_studies_markdown(pairing: PairedStudies) -> str:
    """Return what two studies have in common as tables, graph by graph, and what only one of them has."""
    parts = [f"# {escaped(pairing.plan_a.name)} (A) and {escaped(pairing.plan_b.name)} (B)"]
    for graph in pairing.graphs:
        parts += [f"## {graph}", *_graph(pairing, [row for row in pairing.rows if row.graph == graph])]
    if alone := list(only_in_one(pairing)):
        parts += ["## Only in one of them", bullets(map(escaped, alone))]
    parts += [
        "## How to read and repeat this",
        bullets(map(escaped, _legend(pairing))),
    ]
    sides = (("A", pairing.plan_a), ("B", pairing.plan_b))
    facts = [f"{side}, {name}: {code(value)}" for side, plan in sides for name, value in origin(plan)]
    parts.append(bullets([*facts, *map(escaped, different_versions(pairing))]))
    return document(parts)


def _legend(pairing: PairedStudies) -> tuple[str, ...]:
    primary = pairing.primary
    plan = pairing.plan_b if primary is None else pairing.plan_of(primary)
    decides = deciding(plan, primary)
    own = [_OWN_FRAMES] if any(row.own_frames for row in pairing.rows) else []
    return f"{READING} {decides}", INTERVALS, TESTS, UNTESTED, counting(pairing.plan_b, pairing.metrics), *own


def only_in_one(pairing: PairedStudies) -> Iterator[str]:
    """Yield what has no partner, in plain text."""
    for side, cases in (("A", pairing.only_a), ("B", pairing.only_b)):
        for graph, variant in cases:
            yield f"{graph}, {variant}: only {side} has runs of it"
    for row in pairing.rows:
        for side, seeds in (("A", row.only_a), ("B", row.only_b)):
            if seeds:
                yield f"{row.graph}, {row.variant}: only {side} has the seeds {seeds_text(seeds)}"


def different_versions(pairing: PairedStudies) -> Iterator[str]:
    """Yield which versions differ, in plain text."""
    for name, (a, b) in pairing.different_versions.items():
        yield f"{name}: {a or 'unknown'} in A, {b or 'unknown'} in B"


def _graph(pairing: PairedStudies, rows: Sequence[PairedRow]) -> Iterator[str]:
    metrics = tuple(pairing.metrics)
    for first in range(0, max(len(metrics), 1), METRICS_PER_TABLE):
        some = metrics[first : first + METRICS_PER_TABLE]
        header = ["variant", *(["worlds", "outcomes of A", "outcomes of B"] if first == 0 else [])]
        for metric in some:
            header += [
                f"{escaped(pairing.plan_of(metric).label(metric))}{ARROWS[pairing.metrics[metric]]} A",
                "B",
                "B - A",
            ]
        yield table(header, (_cells(row, some, with_runs=first == 0) for row in rows))


def _cells(row: PairedRow, metrics: Sequence[str], *, with_runs: bool) -> list[str]:
    cells = [escaped(row.variant)]
    if with_runs:
        cells += [str(len(row.seeds)), outcome_counts(row.outcomes_a), outcome_counts(row.outcomes_b)]
    for metric in metrics:
        sides = (row.estimates_a, row.estimates_b)
        cells += [estimate_text(side[metric], len(row.seeds)) if metric in side else "" for side in sides]
        cells.append(OWN_FRAMES if metric in row.own_frames else difference_cell(row.differences.get(metric)))
    return cells
