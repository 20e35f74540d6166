"""How long each stage takes, a bar a variant."""

from __future__ import annotations

from graphnav.ablation.report.bars import stacked_bars
from graphnav.ablation.report.forest import MOST_ROWS
from graphnav.ablation.report.html import Html, details, esc, table, tag
from graphnav.ablation.report.looks import BASE, METHODS, chips
from graphnav.ablation.report.material import Material

_PALETTE = ("#aab4c0", BASE, *METHODS, "#5d6b7a", "#c9b458")


def timing(material: Material) -> Html:
    """Return bars and a table of each graph, of the rows that have runs."""
    parts = []
    for graph in material.plan.graphs:
        rows = {row.case.variant: row.p50_ms for row in material.own_rows(graph) if row.p50_ms}
        if not rows:
            continue
        stages = list(dict.fromkeys(stage for times in rows.values() for stage in times))
        colours = {stage: _PALETTE[place % len(_PALETTE)] for place, stage in enumerate(stages)}
        shown = dict(list(rows.items())[:MOST_ROWS])
        cells = [
            tag("tr", tag("th", esc(variant), scope="row"), *(_cell(times.get(stage)) for stage in stages))
            for variant, times in rows.items()
        ]
        parts.append(tag("h3", esc(graph)) + chips(list(colours.items())))
        parts.append(stacked_bars(shown, colours, "median time of one step, ms"))
        if len(shown) < len(rows):
            parts.append(tag("p", f"Shown are {len(shown)} of {len(rows)}; the table has all.", class_="note"))
        parts.append(details("In numbers, ms", table(["variant", *map(esc, stages)], cells, class_="results")))
    note = "Medians over runs of each run's median step, measured while the study ran, with all its processes beside."
    return "".join([*parts, tag("p", note, class_="note")]) if parts else ""


def _cell(value: float | None) -> Html:
    return tag("td", "\N{EM DASH}" if value is None else f"{value:.2f}", class_="number")
