"""The time per step of each stage, a bar a variant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graphnav.ablation.report.html.charts import stacked_bars
from graphnav.ablation.report.html.markup import Html, details, esc, table, tag
from graphnav.ablation.report.html.sections.forest_plot import MAX_ROWS
from graphnav.ablation.report.html.study_results import StudyResults
from graphnav.ablation.report.html.variant_style import BASE, METHODS, chips

_PALETTE = ("#aab4c0", BASE, *METHODS)
_REST, _REST_COLOUR = "all others", "#dfe3e8"


def timing(study: StudyResults) -> Html:
    """Return bars and a table of each graph, of the rows that have runs."""
    parts = []
    for graph in study.plan.graphs:
        rows = {row.case.variant: row.p50_ms for row in study.own_rows(graph) if row.p50_ms}
        if not rows:
            continue
        stages = list(dict.fromkeys(stage for times in rows.values() for stage in times))
        colours = _colours(stages, rows)
        shown = {variant: _gathered(times, colours) for variant, times in list(rows.items())[:MAX_ROWS]}
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


def _colours(stages: Sequence[str], rows: Mapping[str, Mapping[str, float]]) -> dict[str, str]:
    """Return a colour for each stage, of very many for those that take longest, and one for all others."""
    longest = {stage: max(times.get(stage, 0.0) for times in rows.values()) for stage in stages}
    kept = set(sorted(stages, key=lambda stage: -longest[stage])[: len(_PALETTE)])
    colours = dict(zip((stage for stage in stages if stage in kept), _PALETTE, strict=False))
    return colours if len(kept) == len(stages) else {**colours, _REST: _REST_COLOUR}


def _gathered(times: Mapping[str, float], colours: Mapping[str, str]) -> dict[str, float]:
    """Return the times of the stages that have a colour, and the sum of the others'."""
    own = {stage: times[stage] for stage in colours if stage in times}
    rest = sum(value for stage, value in times.items() if stage not in colours)
    return {**own, _REST: rest} if rest else own


def _cell(value: float | None) -> Html:
    return tag("td", "\N{EM DASH}" if value is None else f"{value:.2f}", class_="number")
