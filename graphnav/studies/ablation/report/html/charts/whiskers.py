"""Dot-and-whisker charts: a row a variant, a panel a graph, one axis for all panels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts.scale import PlacedTick, Scale, scale_of
from graphnav.studies.ablation.report.html.rendering import number, rendered
from graphnav.studies.ablation.report.number_format import format_of

_WIDTH, _GAP, _VALUE = 1128.0, 30.0, 58.0
_CHAR, _MIN_LABEL, _MAX_LABEL = 7.3, 120.0, 330.0
_TOP, _BOTTOM = 30.0, 26.0
_ROWS = (26.0, 21.0)
_MANY_ROWS = 14
PANELS = 3
"""Panels in a row."""


@dataclass(frozen=True)
class Mark:
    """A mean with its interval; ``look``: classes of the style sheet; ``points``: the values that it averages."""

    mean: float
    low: float
    high: float
    look: str
    title: str
    points: Sequence[tuple[float, str]] = ()
    """Each with its own look."""

    @property
    def is_oracle(self) -> bool:
        """Whether the mark is a diamond."""
        return "oracle" in self.look.split()


@dataclass(frozen=True)
class Panel:
    """One graph's marks, by the chart's row; a string replaces a missing mark."""

    title: str
    marks: Mapping[str, Mark | str]
    reference: float | None
    """The base's mean."""


@dataclass(frozen=True)
class _Label:
    """The name of a row, as far as there is room, and the word on what it is."""

    label: str
    shown: str
    role: str
    y: float


@dataclass(frozen=True)
class _PlacedPoint:
    """A value in pixels."""

    x: float
    y: float
    look: str


@dataclass(frozen=True)
class _MarkRow:
    """A mark in pixels, or why there is none."""

    y: float
    missing: str = ""
    mark: Mark | None = None
    value: str = ""
    points: Sequence[_PlacedPoint] = ()
    x: float = 0.0
    low: float = 0.0
    high: float = 0.0
    has_interval: bool = False


@dataclass(frozen=True)
class _PlacedPanel:
    """A panel in pixels."""

    title: str
    start: float
    middle: float
    value_x: float
    ticks: Sequence[PlacedTick]
    reference: float | None
    rows: Sequence[_MarkRow]


def whisker_chart(labels: Mapping[str, str], panels: Sequence[Panel], x_label: str, about: str, columns: int) -> Markup:
    """Return SVG with a row for each of ``labels`` (each with a word on what it is) and room for ``columns`` panels."""
    marks = [mark for panel in panels for mark in panel.marks.values() if isinstance(mark, Mark)]
    values = [value for mark in marks for value in (mark.mean, mark.low, mark.high, *(x for x, _ in mark.points))]
    scale = scale_of(values, max_ticks=5 if columns < PANELS else 4)
    row = _ROWS[len(labels) > _MANY_ROWS]
    heights = {label: _TOP + row * (place + 0.5) for place, label in enumerate(labels)}
    longest = max((len(label) + len(role) + 2 for label, role in labels.items()), default=0)
    left = min(max(longest * _CHAR, _MIN_LABEL), _MAX_LABEL)
    width = (_WIDTH - left) / columns - _GAP
    starts = [left + _GAP + place * (width + _GAP) for place in range(len(panels))]
    return rendered(
        "whiskers.svg",
        about=about,
        x_label=x_label,
        width=_WIDTH,
        height=_TOP + row * len(labels) + _BOTTOM + 16,
        top=_TOP - 6,
        bottom=_TOP + row * len(labels),
        row_px=row,
        labels=[_label(label, role, int(left / _CHAR), heights[label]) for label, role in labels.items()],
        panels=[
            _placed(panel, heights, scale.between(start + 8, start + width - _VALUE))
            for panel, start in zip(panels, starts, strict=True)
        ],
    )


def _label(label: str, role: str, n_chars: int, y: float) -> _Label:
    room = n_chars - len(role) - 1
    return _Label(label, label if len(label) <= room else label[: room - 1] + "…", role, y)


def _placed(panel: Panel, heights: Mapping[str, float], scale: Scale) -> _PlacedPanel:
    base = panel.reference
    return _PlacedPanel(
        panel.title,
        scale.start,
        scale.middle,
        scale.stop + _VALUE - 4,
        scale.placed_ticks(),
        None if base is None or not math.isfinite(base) else scale.at(base),
        [_mark_row(panel.marks.get(label, "not in this graph"), scale, y) for label, y in heights.items()],
    )


def _mark_row(mark: Mark | str, scale: Scale, y: float) -> _MarkRow:
    if isinstance(mark, str):
        return _MarkRow(y, missing=mark)
    has_interval = math.isfinite(mark.low) and math.isfinite(mark.high)
    low, high = (scale.at(mark.low), scale.at(mark.high)) if has_interval else (0.0, 0.0)
    points = [
        _PlacedPoint(scale.at(value), y + ((place * 7) % 5 - 2) * 1.9, look)
        for place, (value, look) in enumerate(mark.points)
    ]
    text = number(mark.mean, format_of(mark.mean, mark.low, mark.high))
    return _MarkRow(y, "", mark, text, points, scale.at(mark.mean), low, high, has_interval)
