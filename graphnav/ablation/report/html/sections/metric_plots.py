"""Charts of the figures that do not decide, and of numeric axes."""

from __future__ import annotations

from graphnav.ablation.report.html.markup import Html, details, esc, tag
from graphnav.ablation.report.html.sections.forest_plot import forest, key
from graphnav.ablation.report.html.sections.parameter_sweeps import sweeps
from graphnav.ablation.report.html.study_results import StudyResults

_MAX_FIGURES = 8
_OPEN = 3


def plots(study: StudyResults) -> Html:
    """Return the lines over numeric axes, then dots with every world; the first few open."""
    figures = [name for name in study.figures[: 1 + _MAX_FIGURES] if _has_worlds(study, name)]
    charts = [
        details(tag("b", esc(figure)), forest(study, figure, with_worlds=True), **({"open": ""} if k < _OPEN else {}))
        for k, figure in enumerate(figures)
    ]
    left_out = len(study.figures) - 1 - _MAX_FIGURES
    if left_out > 0:
        charts.append(tag("p", f"{left_out} more figures are in the tables.", class_="note"))
    return sweeps(study) + (key(with_worlds=True) if figures else "") + "".join(charts)


def _has_worlds(study: StudyResults, figure: str) -> bool:
    """Return whether a figure says more than the first screen did: it is another, or no yes or no."""
    if figure != study.deciding:
        return True
    return any(value not in {0.0, 1.0} for key in study.runs for value in study.values(*key, figure).values())
