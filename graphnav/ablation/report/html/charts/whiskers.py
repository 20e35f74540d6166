"""Dot-and-whisker charts: a row a variant, a panel a graph, one axis for all panels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from graphnav.ablation.report.html.charts.horizontal_axis import x_axis
from graphnav.ablation.report.html.charts.scale import Scale, scale_of
from graphnav.ablation.report.html.markup import Html, esc, tag
from graphnav.ablation.report.html.number_text import number
from graphnav.ablation.report.number_format import format_of

_WIDTH, _GAP, _VALUE = 1128.0, 30.0, 58.0
_CHAR, _MIN_LABEL, _MAX_LABEL = 7.3, 120.0, 330.0
_TOP, _BOTTOM = 30.0, 26.0
_ROWS = (26.0, 21.0)
_MANY_ROWS = 14
PANELS = 3
"""How many stand side by side."""


@dataclass(frozen=True)
class Mark:
    """A mean with its interval; ``look``: classes of the style sheet; ``points``: values that stand behind it."""

    mean: float
    low: float
    high: float
    look: str
    title: str
    points: Sequence[tuple[float, str]] = ()
    """Each with its own look."""


@dataclass(frozen=True)
class Panel:
    """One graph's marks, by the chart's row; a text stands where a row has no mark."""

    title: str
    marks: Mapping[str, Mark | str]
    reference: float | None
    """The base's mean."""


def whisker_chart(labels: Mapping[str, str], panels: Sequence[Panel], x_label: str, about: str, columns: int) -> Html:
    """Return SVG with a row for each of ``labels`` (each with a word on what it is) and room for ``columns`` panels."""
    marks = [mark for panel in panels for mark in panel.marks.values() if isinstance(mark, Mark)]
    values = [value for mark in marks for value in (mark.mean, mark.low, mark.high, *(x for x, _ in mark.points))]
    scale = scale_of(values, max_ticks=5 if columns < PANELS else 4)
    row = _ROWS[len(labels) > _MANY_ROWS]
    longest = max((len(label) + len(role) + 2 for label, role in labels.items()), default=0)
    left = min(max(longest * _CHAR, _MIN_LABEL), _MAX_LABEL)
    height = _TOP + row * len(labels) + _BOTTOM + 16
    width = (_WIDTH - left) / columns - _GAP
    parts = [_labels(labels, left, row)]
    for place, panel in enumerate(panels):
        start = left + _GAP + place * (width + _GAP)
        inner = scale.between(start + 8, start + width - _VALUE)
        parts.append(_panel(panel, list(labels), inner, row, x_label))
    attributes = {"viewBox": f"0 0 {_WIDTH:.0f} {height:.0f}", "role": "img", "aria_label": about}
    return tag("div", tag("svg", *parts, class_="chart", width=f"{_WIDTH:.0f}", **attributes), class_="scroll")


def _labels(labels: Mapping[str, str], left: float, row: float) -> Html:
    parts = []
    for place, (label, role) in enumerate(labels.items()):
        y = _TOP + row * (place + 0.5)
        room = int(left / _CHAR) - len(role) - 1
        shown = label if len(label) <= room else label[: room - 1] + "…"
        badge = tag("tspan", esc(role), dx=6, class_="badge") if role else ""
        text = tag("title", esc(label)) + esc(shown) + badge
        parts.append(tag("text", text, x=0, y=f"{y + 4:.1f}", class_="label base" if role == "base" else "label"))
        parts.append(f'<path class="rule" d="M0,{y + row / 2:.1f}H{_WIDTH:.0f}"/>')
    return "".join(parts)


def _panel(panel: Panel, labels: Sequence[str], scale: Scale, row: float, x_label: str) -> Html:
    bottom = _TOP + row * len(labels)
    parts = [tag("text", esc(panel.title), x=f"{scale.start:.1f}", y=14, class_="head")]
    parts += x_axis(scale, _TOP - 6, bottom, x_label)
    if panel.reference is not None and math.isfinite(panel.reference):
        parts.append(f'<path class="reference" d="M{scale.at(panel.reference):.1f},{_TOP - 6:.1f}V{bottom:.1f}"/>')
    for place, label in enumerate(labels):
        y = _TOP + row * (place + 0.5)
        mark = panel.marks.get(label, "not in this graph")
        if isinstance(mark, str):
            parts.append(tag("text", esc(mark), x=f"{scale.start:.1f}", y=f"{y + 4:.1f}", class_="absent"))
        else:
            parts.append(_mark(mark, scale, y))
    return "".join(parts)


def _mark(mark: Mark, scale: Scale, y: float) -> Html:
    x = scale.at(mark.mean)
    parts = [tag("title", esc(mark.title))]
    for place, (value, look) in enumerate(mark.points):
        up = ((place * 7) % 5 - 2) * 1.9
        parts.append(f'<circle class="point {look}" cx="{scale.at(value):.1f}" cy="{y + up:.1f}" r="2"/>')
    if math.isfinite(mark.low) and math.isfinite(mark.high):
        parts.append(f'<path class="whisker" d="M{scale.at(mark.low):.1f},{y:.1f}H{scale.at(mark.high):.1f}"/>')
    if "oracle" in mark.look:
        parts.append(f'<path class="dot" d="M{x:.1f},{y - 5.5:.1f}l5.5,5.5l-5.5,5.5l-5.5,-5.5z"/>')
    else:
        parts.append(f'<circle class="dot" cx="{x:.1f}" cy="{y:.1f}" r="4.5"/>')
    text = number(mark.mean, format_of(mark.mean, mark.low, mark.high))
    parts.append(tag("text", text, x=f"{scale.stop + _VALUE - 4:.1f}", y=f"{y + 4:.1f}", class_="value"))
    return tag("g", *parts, class_=mark.look)
