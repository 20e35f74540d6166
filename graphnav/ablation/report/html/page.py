"""Assemble the page and write it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from pathlib import Path

from graphnav.ablation.plan import Plan
from graphnav.ablation.report.atomic_write import write_atomically
from graphnav.ablation.report.html.markup import Html, esc, section, tag
from graphnav.ablation.report.html.sections import drawings, gallery, maps, overview, plots, reproduce, tables, timing
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.results import Comparison, Record
from graphnav.catalog import Catalog

REPORT = "report.html"


def write_report(plan: Plan, comparison: Comparison, records: Sequence[Record], folder: Path, catalog: Catalog) -> Path:
    """Write ``report.html`` into the folder of a study, and the maps with paths that it shows; return its path.

    The page needs no other file, no script and no network. The same runs and pictures give the same bytes.
    """
    study = StudyResults(plan, comparison, records, folder, catalog)
    path = folder / REPORT
    write_atomically(path, page_of(study))
    return path


def page_of(study: StudyResults) -> Html:
    """Return the whole page."""
    parts = {
        "graph": ("What was swapped", drawings(study)),
        "tables": ("Results", tables(study)),
        "plots": ("Metrics", plots(study)),
        "paths": ("Paths", maps(study)),
        "time": ("Time per stage", timing(study)),
        "failures": ("Failures", gallery(study)),
        "reproduce": ("Reproduce", reproduce(study)),
    }
    style = resources.files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    links = [tag("a", esc(title), href=f"#{name}") for name, (title, body) in parts.items() if body]
    sections = [section(name, title, body) for name, (title, body) in parts.items()]
    return "\n".join(
        [
            '<!doctype html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta name="color-scheme" content="light dark">',
            tag("title", esc(f"{study.plan.name}: {study.plan.about}")),
            f"<style>{style}</style></head><body>",
            tag("nav", *links),
            f"<main>{overview(study)}",
            *sections,
            "</main></body></html>\n",
        ]
    )
