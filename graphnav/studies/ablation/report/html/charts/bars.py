"""Stacked bars: a row a variant, a segment a part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts.scale import Scale, scale_of
from graphnav.studies.ablation.report.html.rendering import rendered

_WIDTH, _LEFT, _RIGHT, _ROW, _BOTTOM = 1128.0, 300.0, 70.0, 24.0, 40.0
_CHAR = 7.3


@dataclass(frozen=True)
class _Segment:
    """A part of a bar, in pixels."""

    name: str
    value: float
    colour: str
    x: float
    width: float


@dataclass(frozen=True)
class _Bar:
    """A row; ``shown``: its label as far as there is room."""

    label: str
    shown: str
    y: float
    segments: Sequence[_Segment]
    total: float


def stacked_bars(rows: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], x_label: str) -> Markup:
    """Return SVG with a bar for each of ``rows``: its parts by name, each in its colour."""
    scale = scale_of([0.0, *(sum(parts.values()) for parts in rows.values())]).between(_LEFT, _WIDTH - _RIGHT)
    room = int(_LEFT / _CHAR) - 1
    bars = [
        _Bar(
            label,
            label if len(label) <= room else label[: room - 1] + "…",
            place * _ROW + _ROW / 2 + 2,
            list(_segments(parts, colours, scale)),
            sum(parts.values()),
        )
        for place, (label, parts) in enumerate(rows.items())
    ]
    bottom = _ROW * len(rows) + 4
    return rendered(
        "bars.svg",
        bars=bars,
        x_label=x_label,
        ticks=scale.placed_ticks(),
        bottom=bottom,
        middle=scale.middle,
        width=_WIDTH,
        height=bottom + _BOTTOM,
    )


def _segments(parts: Mapping[str, float], colours: Mapping[str, str], scale: Scale) -> Iterator[_Segment]:
    begin = 0.0
    for name, value in parts.items():
        x = scale.at(begin)
        yield _Segment(name, value, colours[name], x, scale.at(begin + value) - x)
        begin += value
