"""The horizontal axis of a chart: grid lines, tick labels, title."""

from __future__ import annotations

from graphnav.ablation.report.html.charts.scale import Scale
from graphnav.ablation.report.html.markup import Html, esc, tag


def x_axis(scale: Scale, top: float, bottom: float, label: str) -> list[Html]:
    """Return SVG with a grid line from ``top`` to ``bottom`` at every tick, and below them numbers and ``label``."""
    parts = []
    for tick in scale.ticks:
        x = scale.at(tick)
        parts.append(f'<path class="grid" d="M{x:.1f},{top:.1f}V{bottom:.1f}"/>')
        parts.append(tag("text", scale.said(tick), x=f"{x:.1f}", y=f"{bottom + 15:.1f}", class_="tick"))
    middle = f"{(scale.start + scale.stop) / 2:.1f}"
    return [*parts, tag("text", esc(label), x=middle, y=f"{bottom + 32:.1f}", class_="axis")]
