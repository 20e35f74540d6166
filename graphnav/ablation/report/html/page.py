"""Put the page together and write it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources
from pathlib import Path

from graphnav.ablation.results.compare_variants import Comparison
from graphnav.ablation.plan.plan import Plan
from graphnav.ablation.results.records import Record
from graphnav.ablation.report.html.sections.first_screen import answer
from graphnav.ablation.report.html.sections.graph_drawings import drawings
from graphnav.ablation.report.html.sections.failure_gallery import gallery
from graphnav.ablation.report.html.markup import Html, esc, section, tag
from graphnav.ablation.report.html.sections.path_maps import maps
from graphnav.ablation.report.html.study_results import Material
from graphnav.ablation.report.html.sections.metric_plots import plots
from graphnav.ablation.report.html.sections.reproduction import reproduce
from graphnav.ablation.report.html.sections.result_tables import tables
from graphnav.ablation.report.html.sections.step_times import timing
from graphnav.ablation.report.atomic_write import write_whole
from graphnav.catalog import Catalog

REPORT = "report.html"


def write_report(plan: Plan, comparison: Comparison, records: Sequence[Record], folder: Path, catalog: Catalog) -> Path:
    """Write ``report.html`` into the folder of a study, and the maps with paths that it shows; return its path.

    The page needs no other file, no script and no network. The same runs and pictures give the same bytes.
    """
    material = Material(plan, comparison, records, folder, catalog)
    path = folder / REPORT
    write_whole(path, page_of(material))
    return path


def page_of(material: Material) -> Html:
    """Return the whole page."""
    parts = {
        "graph": ("What was swapped", drawings(material)),
        "tables": ("Results", tables(material)),
        "plots": ("Figures", plots(material)),
        "paths": ("Paths", maps(material)),
        "time": ("Time per stage", timing(material)),
        "failures": ("Failures", gallery(material)),
        "reproduce": ("Reproduce", reproduce(material)),
    }
    style = resources.files(__package__).joinpath("style.css").read_text(encoding="utf-8")
    links = [tag("a", esc(title), href=f"#{name}") for name, (title, body) in parts.items() if body]
    sections = [section(name, title, body) for name, (title, body) in parts.items()]
    return "\n".join(
        [
            '<!doctype html><html lang="en"><head><meta charset="utf-8">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            '<meta name="color-scheme" content="light dark">',
            tag("title", esc(f"{material.plan.name}: {material.plan.about}")),
            f"<style>{style}</style></head><body>",
            tag("nav", *links),
            f"<main>{answer(material)}",
            *sections,
            "</main></body></html>\n",
        ]
    )
