"""Line charts: a metric over a numeric axis, a line a series, bands for the intervals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts.scale import PlacedTick, Scale, scale_of, wide_scale_of
from graphnav.studies.ablation.report.html.rendering import rendered

_HEIGHT = 300.0
HALF_WIDTH, FULL_WIDTH = 556.0, 1128.0
"""Widths of charts that share a row, and of one that fills it."""
_LEFT, _TOP, _BOTTOM, _CHAR = 46.0, 34.0, 46.0, 7.8
_MAX_NAME = 26
_LINE = 15.0
_MAX_ENDS = 8
"""So many points of the axis get a tick each, in place of round numbers."""


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


@dataclass(frozen=True)
class _Dot:
    """A point in pixels, with its numbers."""

    x: float
    y: float
    text: str


@dataclass(frozen=True)
class _Line:
    """A series in pixels; ``band``: the corners of its intervals, ``name``: its name as far as there is room."""

    series: Series
    dots: Sequence[_Dot]
    band: Sequence[tuple[float, float]]
    name: str
    name_y: float


def line_chart(title: str, x_label: str, series: Sequence[Series], width: float = HALF_WIDTH) -> Markup:
    """Return SVG; each line's name is at its right end."""
    points = [point for one in series for point in one.points]
    names = [one.name if len(one.name) <= _MAX_NAME else one.name[: _MAX_NAME - 1] + "…" for one in series]
    right = width - 14 - max((len(name) for name in names), default=0) * _CHAR
    ends = sorted({point.x for point in points})
    across = scale_of(ends).between(_LEFT, right)
    up = wide_scale_of([y for p in points for y in (p.mean, p.low, p.high)]).between(_HEIGHT - _BOTTOM, _TOP)
    wanted = [up.at(one.points[-1].mean) if one.points else _HEIGHT for one in series]
    lines = [
        _Line(one, _dots(one, across, up), _band(one, across, up), name, y)
        for one, name, y in zip(series, names, _spread(wanted), strict=True)
    ]
    return rendered(
        "lines.svg",
        title=title,
        x_label=x_label,
        width=width,
        height=_HEIGHT,
        left=across.start,
        right=across.stop,
        bottom=up.start,
        up=up.placed_ticks(),
        across=[PlacedTick(across.at(x), f"{x:g}") for x in (ends if 0 < len(ends) <= _MAX_ENDS else across.ticks)],
        lines=lines,
    )


def _band(series: Series, across: Scale, up: Scale) -> list[tuple[float, float]]:
    known = [p for p in series.points if math.isfinite(p.low) and math.isfinite(p.high)]
    edge = [(p.x, p.high) for p in known] + [(p.x, p.low) for p in reversed(known)]
    return [(across.at(x), up.at(y)) for x, y in edge]


def _dots(series: Series, across: Scale, up: Scale) -> list[_Dot]:
    return [
        _Dot(across.at(p.x), up.at(p.mean), f"{p.mean:.4g} [{p.low:.4g}, {p.high:.4g}] at {p.x:g}")
        for p in series.points
    ]


def _spread(wanted: Sequence[float]) -> list[float]:
    """Return heights in the order given, moved so that no two are nearer than a line of text."""
    order = sorted(range(len(wanted)), key=lambda k: wanted[k])
    placed = list(wanted)
    for above, below in pairwise(order):
        placed[below] = max(placed[below], placed[above] + _LINE)
    over = max((placed[k] for k in order), default=0.0) - (_HEIGHT - _BOTTOM + 6)
    return [y - max(over, 0.0) for y in placed]
