"""Stacked bars: a row a variant, a segment a part."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from graphnav.ablation.report.html.charts.horizontal_axis import x_axis
from graphnav.ablation.report.html.charts.scale import scale_of
from graphnav.ablation.report.html.markup import Html, esc, tag

_WIDTH, _LEFT, _RIGHT, _ROW, _BOTTOM = 1128.0, 300.0, 70.0, 24.0, 40.0
_CHAR = 7.3


def stacked_bars(rows: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], x_label: str) -> Html:
    """Return SVG with a bar for each of ``rows``: its parts by name, each in its colour."""
    totals = {label: sum(parts.values()) for label, parts in rows.items()}
    scale = scale_of([0.0, *totals.values()]).between(_LEFT, _WIDTH - _RIGHT)
    bottom = _ROW * len(rows) + 4
    parts = x_axis(scale, 0.0, bottom, x_label)
    for place, (label, of) in enumerate(rows.items()):
        parts.append(_bar(label, of, colours, scale.at, place * _ROW + _ROW / 2 + 2))
        total = tag("text", f"{totals[label]:.1f}", x=f"{_WIDTH - 4:.1f}", y=f"{place * _ROW + 18:.1f}", class_="value")
        parts.append(total)
    box = f"0 0 {_WIDTH:.0f} {bottom + _BOTTOM:.0f}"
    svg = tag("svg", *parts, class_="chart", viewBox=box, width=f"{_WIDTH:.0f}", role="img", aria_label=x_label)
    return tag("div", svg, class_="scroll")


def _bar(
    label: str, parts: Mapping[str, float], colours: Mapping[str, str], at: Callable[[float], float], y: float
) -> Html:
    room = int(_LEFT / _CHAR) - 1
    shown = label if len(label) <= room else label[: room - 1] + "…"
    drawn = [tag("text", tag("title", esc(label)) + esc(shown), x=0, y=f"{y + 4:.1f}", class_="label")]
    begin = 0.0
    for name, value in parts.items():
        x, width = at(begin), at(begin + value) - at(begin)
        title = tag("title", f"{esc(name)}: {value:.2f}")
        shape = f'x="{x:.2f}" y="{y - 7:.1f}" width="{width:.2f}" height="14" style="fill:{esc(colours[name])}"'
        drawn.append(f"<rect {shape}>{title}</rect>")
        begin += value
    return "".join(drawn)
