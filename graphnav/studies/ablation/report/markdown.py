"""``table.md``, and two studies side by side, in Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from graphnav.core.errors import printable
from graphnav.core.tables import escaped
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.decomposition import heading, loss_table, notes, sentences
from graphnav.studies.ablation.report.legend import (
    INTERVALS,
    OWN_FRAMES,
    TESTS,
    UNTESTED,
    counting,
    deciding,
    legend,
    origin,
    same_graphs,
    seeds_text,
)
from graphnav.studies.ablation.report.tables import comparison_table, paired_table
from graphnav.studies.ablation.results import (
    Comparison,
    Losses,
    PairedStudies,
    shown_metrics,
)

TABLE = "table.md"


def table_markdown(plan: Plan, comparison: Comparison, found: Sequence[Losses] = (), notes: Sequence[str] = ()) -> str:
    """Return the table of a study, graph by graph, with how to read it and how to reproduce it.

    ``found``: what a decomposed study lost where. ``notes``: sentences on the number of worlds.
    """
    parts = [f"# {plan.name}", *([escaped(plan.about)] if plan.about else []), *_decomposition(plan, found)]
    for graph in plan.graphs:
        parts += [f"## {graph}", *_graph(plan, comparison, graph)]
    if notes:
        parts += ["## Number of worlds", bullets(map(escaped, notes))]
    parts += ["## How to read and repeat this", bullets(map(escaped, legend(plan, comparison)))]
    parts.append(bullets(f"{name}: {code(value)}" for name, value in origin(plan)))
    return document(parts)


def _decomposition(plan: Plan, found: Sequence[Losses]) -> Iterator[str]:
    if not found:
        return
    yield "## Where it is lost"
    for of in found:
        yield f"### {escaped(heading(of))}"
        yield escaped(" ".join(sentences(plan, of)))
        if of.is_cut_off:
            continue
        yield loss_table(of).markdown()
    yield bullets(map(escaped, notes(plan, found)))


def document(parts: Iterable[str]) -> str:
    """Return paragraphs as a file in which nothing is invisible or changes the order of the text."""
    return printable("\n\n".join(parts)) + "\n"


def bullets(lines: Iterable[str]) -> str:
    """Return a Markdown list."""
    return "\n".join(f"- {line}" for line in lines)


def code(text: str) -> str:
    """Return a string as code."""
    return f"`{text}`" if "`" not in text else escaped(text)


def _graph(plan: Plan, comparison: Comparison, graph: str) -> Iterator[str]:
    of_graph = comparison.of_graph(graph)
    yield from comparison_table(plan, comparison, graph, shown_metrics(plan, comparison)).markdown_parts()
    if alike := list(same_graphs(of_graph)):
        yield bullets(map(escaped, alike))
    own = [row for row in of_graph if not row.case.same_as]
    failed = [(row, reason, times) for row in own for reason, times in row.failures.items()]
    if failed:
        yield "Failed runs:"
        yield bullets(f"{escaped(row.case.variant)}, {times}: {escaped(reason)}" for row, reason, times in failed)


_PAIRED_READING = (
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
        found = paired_table(pairing, graph, tuple(pairing.metrics), has_outcomes=True)
        parts += [f"## {graph}", *found.markdown_parts()]
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
    return f"{_PAIRED_READING} {decides}", INTERVALS, TESTS, UNTESTED, counting(pairing.plan_b, pairing.metrics), *own


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
