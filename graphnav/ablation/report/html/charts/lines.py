"""Line charts: a metric over a numeric axis, a line a series, bands for the intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from graphnav.ablation.report.html.charts.scale import Scale, scale_of, wide_scale_of
from graphnav.ablation.report.html.markup import Html, esc, tag

_HEIGHT = 300.0
HALF_WIDTH, FULL_WIDTH = 556.0, 1128.0
"""Widths of charts that stand side by side, and of one that stands alone."""
_LEFT, _TOP, _BOTTOM, _CHAR = 46.0, 34.0, 46.0, 7.8
_MAX_NAME = 26
_LINE = 15.0


@dataclass(frozen=True)
class Point:
    """A mean at a place of the axis, with its interval."""

    x: float
    mean: float
    low: float
    high: float


@dataclass(frozen=True)
class Series:
    """One line."""

    name: str
    points: Sequence[Point]
    colour: str
    is_dashed: bool = False


def line_chart(title: str, x_label: str, series: Sequence[Series], width: float = HALF_WIDTH) -> Html:
    """Return SVG; each line's name stands at its right end."""
    points = [point for one in series for point in one.points]
    names = [one.name if len(one.name) <= _MAX_NAME else one.name[: _MAX_NAME - 1] + "…" for one in series]
    right = width - 14 - max((len(name) for name in names), default=0) * _CHAR
    ends = sorted({point.x for point in points})
    across = scale_of(ends).between(_LEFT, right)
    up = wide_scale_of([y for p in points for y in (p.mean, p.low, p.high)]).between(_HEIGHT - _BOTTOM, _TOP)
    parts = [tag("text", esc(title), x=0, y=14, class_="head"), _axes(across, up, x_label, ends)]
    parts += [_band(one, across, up) for one in series]
    parts += [_line(one, across, up) for one in series]
    wanted = [up.at(one.points[-1].mean) if one.points else _HEIGHT for one in series]
    for one, name, y in zip(series, names, _spread(wanted), strict=True):
        look = f"fill:{one.colour}"
        text = tag("title", esc(one.name)) + esc(name)
        parts.append(tag("text", text, x=f"{right + 10:.1f}", y=f"{y + 4:.1f}", style=look, class_="name"))
    box = f"0 0 {width:.0f} {_HEIGHT:.0f}"
    return tag("svg", *parts, class_="chart", viewBox=box, width=f"{width:.0f}", role="img", aria_label=title)


def _axes(across: Scale, up: Scale, x_label: str, ends: Sequence[float]) -> Html:
    parts = []
    for tick in up.ticks:
        y = up.at(tick)
        parts.append(f'<path class="grid" d="M{across.start:.1f},{y:.1f}H{across.stop:.1f}"/>')
        text = up.said(tick)
        parts.append(tag("text", text, x=f"{across.start - 8:.1f}", y=f"{y + 4:.1f}", class_="value"))
    shown = ends if 0 < len(ends) <= 8 else across.ticks
    for tick in shown:
        parts.append(tag("text", f"{tick:g}", x=f"{across.at(tick):.1f}", y=f"{up.start + 18:.1f}", class_="tick"))
        parts.append(f'<path class="rule" d="M{across.at(tick):.1f},{up.start:.1f}v4"/>')
    middle = f"{(across.start + across.stop) / 2:.1f}"
    parts.append(tag("text", esc(x_label), x=middle, y=f"{up.start + 38:.1f}", class_="axis"))
    return "".join(parts)


def _band(series: Series, across: Scale, up: Scale) -> Html:
    there = [p for p in series.points if math.isfinite(p.low) and math.isfinite(p.high)]
    edge = [(p.x, p.high) for p in there] + [(p.x, p.low) for p in reversed(there)]
    corners = " ".join(f"{across.at(x):.1f},{up.at(y):.1f}" for x, y in edge)
    return f'<polygon points="{corners}" style="fill:{series.colour}" opacity="0.13"/>' if there else ""


def _line(series: Series, across: Scale, up: Scale) -> Html:
    places = [(across.at(p.x), up.at(p.mean)) for p in series.points]
    path = "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in places)
    dashes = ' stroke-dasharray="5 4"' if series.is_dashed else ""
    line = f'<path class="line" d="{path}" style="stroke:{series.colour}"{dashes}/>' if places else ""
    dots = [
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.2" style="fill:{series.colour}">'
        f"<title>{esc(series.name)}: {p.mean:.4g} [{p.low:.4g}, {p.high:.4g}] at {p.x:g}</title></circle>"
        for (x, y), p in zip(places, series.points, strict=True)
    ]
    return line + "".join(dots)


def _spread(wanted: Sequence[float]) -> list[float]:
    """Return heights in the order given, moved so that no two are nearer than a line of text."""
    order = sorted(range(len(wanted)), key=lambda k: wanted[k])
    placed = list(wanted)
    for above, below in pairwise(order):
        placed[below] = max(placed[below], placed[above] + _LINE)
    over = max((placed[k] for k in order), default=0.0) - (_HEIGHT - _BOTTOM + 6)
    return [y - max(over, 0.0) for y in placed]
