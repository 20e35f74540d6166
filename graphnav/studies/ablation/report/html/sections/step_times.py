"""The time per step of each stage, a bar a variant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts import stacked_bars
from graphnav.studies.ablation.report.html.render import rendered
from graphnav.studies.ablation.report.html.sections.forest_plot import MAX_ROWS
from graphnav.studies.ablation.report.html.study_results import StudyResults
from graphnav.studies.ablation.report.html.variant_style import BASE, METHODS

_PALETTE = ("#aab4c0", BASE, *METHODS)
_REST, _REST_COLOUR = "all others", "#dfe3e8"


@dataclass(frozen=True)
class _GraphTimes:
    """Bars of the first ``n_shown`` rows, and the times of all in milliseconds by variant and stage."""

    name: str
    colours: Mapping[str, str]
    bars: Markup
    n_shown: int
    stages: list[str]
    rows: Mapping[str, Mapping[str, float]]


def timing(study: StudyResults) -> Markup:
    """Return bars and a table of each graph, of the rows that have runs."""
    graphs = []
    for graph in study.plan.graphs:
        rows = {row.case.variant: row.p50_ms for row in study.own_rows(graph) if row.p50_ms}
        if rows:
            graphs.append(_graph_times(graph, rows))
    return rendered("step_times.html", graphs=graphs)


def _graph_times(graph: str, rows: Mapping[str, Mapping[str, float]]) -> _GraphTimes:
    stages = list(dict.fromkeys(stage for times in rows.values() for stage in times))
    colours = _colours(stages, rows)
    shown = {variant: _gathered(times, colours) for variant, times in list(rows.items())[:MAX_ROWS]}
    bars = stacked_bars(shown, colours, "median time of one step, ms")
    return _GraphTimes(graph, colours, bars, len(shown), stages, rows)


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
