"""Charts of the figures that do not decide, and of numeric axes."""

from __future__ import annotations

from graphnav.ablation.report.html.sections.forest_plot import forest, key
from graphnav.ablation.report.html.markup import Html, details, esc, tag
from graphnav.ablation.report.html.study_results import Material
from graphnav.ablation.report.html.sections.parameter_sweeps import sweeps

_MOST_FIGURES = 8
_OPEN = 3


def plots(material: Material) -> Html:
    """Return the lines over numeric axes, then dots with every world; the first few open."""
    figures = [name for name in material.figures[: 1 + _MOST_FIGURES] if _has_worlds(material, name)]
    charts = [
        details(
            tag("b", esc(figure)), forest(material, figure, with_worlds=True), **({"open": ""} if k < _OPEN else {})
        )
        for k, figure in enumerate(figures)
    ]
    left_out = len(material.figures) - 1 - _MOST_FIGURES
    if left_out > 0:
        charts.append(tag("p", f"{left_out} more figures are in the tables.", class_="note"))
    return sweeps(material) + (key(with_worlds=True) if figures else "") + "".join(charts)


def _has_worlds(material: Material, figure: str) -> bool:
    """Return whether a figure says more than the first screen did: it is another, or no yes or no."""
    if figure != material.deciding:
        return True
    return any(value not in {0.0, 1.0} for key in material.runs for value in material.values(*key, figure).values())
