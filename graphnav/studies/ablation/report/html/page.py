"""Assemble the page, from its first screen (question, answer, what was compared, what decides) on, and write it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from markupsafe import Markup

from graphnav import Graph
from graphnav.core.catalog import Catalog
from graphnav.core.machine import write_atomically
from graphnav.studies.ablation.plan import Plan
from graphnav.studies.ablation.report.html.forest_plot import chart_key, forest
from graphnav.studies.ablation.report.html.plots import deciding_sweeps, plots
from graphnav.studies.ablation.report.html.rendering import counted, rendered
from graphnav.studies.ablation.report.html.reproduction import drawings, reproduce
from graphnav.studies.ablation.report.html.result_tables import decomposition, pair_matrices, tables, timing
from graphnav.studies.ablation.report.html.run_pictures import gallery, maps
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.verdicts import headline, reference_values, variants_by_verdict, verdicts
from graphnav.studies.ablation.report.legend import too_few_worlds, worlds_of_graphs
from graphnav.studies.ablation.results import Comparison, Record

REPORT = "report.html"
_MAX_NAMED = 6
"""Variants that a warning names."""


class _Section(NamedTuple):
    """A part of the page that ``#name`` finds; it is left out where its body is empty."""

    name: str
    title: str
    body: Markup


def write_report(
    plan: Plan,
    comparison: Comparison,
    records: Sequence[Record],
    folder: Path,
    catalog: Catalog,
    graphs: Mapping[str, Graph] = MappingProxyType({}),
    notes: Sequence[str] = (),
    drawn: frozenset[Path] = frozenset(),
) -> Path:
    """Write ``report.html`` into the folder of a study, and the maps with paths that it shows; return its path.

    The page needs no other file, no script and no network. The same runs and pictures give the same bytes. ``graphs``:
    those that are loaded already, by `Case.folder`; ``notes``: sentences on the number of worlds; ``drawn``: maps that
    are drawn already.
    """
    study = StudyResults(plan, comparison, records, folder, catalog, graphs, notes, drawn)
    path = folder / REPORT
    write_atomically(path, page_of(study))
    return path


def page_of(study: StudyResults) -> Markup:
    """Return the page."""
    sections = [
        _Section("decomposition", "Where it is lost", decomposition(study)),
        _Section("graph", "What was swapped", drawings(study)),
        _Section("tables", "Results", tables(study)),
        _Section("pairs", "All pairs", pair_matrices(study)),
        _Section("plots", "Metrics", plots(study)),
        _Section("paths", "Paths", maps(study)),
        _Section("time", "Time per stage", timing(study)),
        _Section("failures", "Failures", gallery(study)),
        _Section("reproduce", "Reproduce", reproduce(study)),
    ]
    title = f"{study.plan.name}: {study.plan.about}"
    return rendered("page.html", title=title, overview=overview(study), sections=sections) + "\n"


def overview(study: StudyResults) -> Markup:
    """Return the head of the page."""
    metric = study.deciding
    n, n_pending = study.comparison.runs, study.comparison.pending
    missing = f"not finished: so far {n} of {counted(n + n_pending, 'run')}"
    if study.plan.until_clear:
        missing = f"not finished: so far {counted(n, 'run')}, {n_pending} more in the next round"
    nothing = Markup("")
    charts = answer = verdicts_drawn = references = nothing
    if metric is not None:
        charts = deciding_sweeps(study) + forest(study, metric) + chart_key()
    if metric is not None and n:
        found = verdicts(study, metric)
        answer = headline(study, metric, found)
        verdicts_drawn, references = variants_by_verdict(study, metric, found), reference_values(study, metric)
    return rendered(
        "first_screen.html",
        plan=study.plan,
        is_finished=not n_pending,
        state=missing if n_pending else f"finished: {counted(n, 'run')}",
        answer=answer,
        verdicts=verdicts_drawn,
        references=references,
        setup=_setup(study),
        warnings=[text for text in (too_few_worlds(study.plan, study.comparison), _fewer_worlds(study)) if text],
        charts=charts,
    )


def _fewer_worlds(study: StudyResults) -> str:
    """Return of which variants the deciding metric tells fewer worlds than were run, as where stages failed."""
    metric = study.deciding
    rows = [row for graph in study.plan.graphs for row in study.own_rows(graph)] if metric is not None else []
    fewer = [
        f"{row.case.variant} {found.n} of {row.runs}" + (f" on {row.case.graph}" if len(study.plan.graphs) > 1 else "")
        for row in rows
        if (found := row.estimates.get(metric or "")) is not None and found.n < row.runs
    ]
    if not fewer:
        return ""
    more = f", and {len(fewer) - _MAX_NAMED} more" if len(fewer) > _MAX_NAMED else ""
    names = ", ".join(fewer[:_MAX_NAMED])
    return f"{metric} is known in fewer worlds than were run, its mean is of these alone: {names}{more}."


def _setup(study: StudyResults) -> list[tuple[str, str]]:
    plan = study.plan
    shared = sum(bool(case.same_as) for case in plan.cases)
    same = f"; {shared} of {len(plan.cases)} cases are the same graph as another" if shared else ""
    return [
        ("worlds", f"seeds {worlds_of_graphs(plan)}, the same for all variants"),
        ("graphs", ", ".join(plan.sources)),
        *([("compared under the same", ", ".join(plan.within))] if plan.within else []),
        ("variants", f"{len(plan.variants)}{same}"),
        ("base", plan.base),
        ("decides", _deciding(study)),
    ]


def _deciding(study: StudyResults) -> str:
    metric, plan = study.deciding, study.plan
    if not metric:
        return "no metric"
    smallest = plan.min_difference(metric)
    matters = f", differences matter from {smallest:g}" if smallest else ""
    return f"{plan.label(metric)}, {plan.better(metric)} is better{matters}"
