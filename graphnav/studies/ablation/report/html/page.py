"""Assemble the page and write it."""

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
from graphnav.studies.ablation.report.html.first_screen import overview
from graphnav.studies.ablation.report.html.plots import plots
from graphnav.studies.ablation.report.html.rendering import rendered
from graphnav.studies.ablation.report.html.reproduction import drawings, reproduce
from graphnav.studies.ablation.report.html.result_tables import decomposition, pair_matrices, tables, timing
from graphnav.studies.ablation.report.html.run_pictures import gallery, maps
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.results import Comparison, Record

REPORT = "report.html"


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
) -> Path:
    """Write ``report.html`` into the folder of a study, and the maps with paths that it shows; return its path.

    The page needs no other file, no script and no network. The same runs and pictures give the same bytes. ``graphs``:
    those that are loaded already, by `Case.folder`; ``notes``: sentences on the number of worlds.
    """
    study = StudyResults(plan, comparison, records, folder, catalog, graphs, notes)
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
