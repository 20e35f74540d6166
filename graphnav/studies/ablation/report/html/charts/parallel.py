"""Parallel coordinates: a line a variant, through its choice on each axis, to its metric."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from markupsafe import Markup

from graphnav.core.stage import Better
from graphnav.studies.ablation.report.html.charts.lines import FULL_WIDTH
from graphnav.studies.ablation.report.html.charts.scale import PlacedTick, Scale, scale_of
from graphnav.studies.ablation.report.html.rendering import number, rendered

_LEFT, _RIGHT, _TOP, _BOTTOM = 14.0, 60.0, 52.0, 14.0
_ROW, _MIN_HEIGHT = 46.0, 220.0
_FAN = 0.62
"""The share of a choice's room over which the lines through it spread."""
_WORST, _MIDDLE, _BEST = (209, 73, 91), (168, 176, 188), (42, 157, 143)


@dataclass(frozen=True)
class Strand:
    """A variant: its choice on each axis and its metric."""

    name: str
    labels: Sequence[str]
    value: float


@dataclass(frozen=True)
class _Column:
    """An axis in pixels, with the places of its choices."""

    name: str
    x: float
    choices: Sequence[PlacedTick]


@dataclass(frozen=True)
class _Path:
    """A strand in pixels."""

    text: str
    d: str
    colour: str


def parallel_chart(
    title: str, axes: Mapping[str, Sequence[str]], strands: Sequence[Strand], metric: str, better: Better
) -> Markup:
    """Return SVG; the better end of the metric is up, and lines are coloured from the worst to the best."""
    height = max(_MIN_HEIGHT, _ROW * max(len(labels) for labels in axes.values()))
    top, bottom = _TOP, _TOP + height
    ordered = sorted(strands, key=lambda strand: strand.value, reverse=better == "lower")
    spread = scale_of([strand.value for strand in strands])
    scale = spread.between(top, bottom) if better == "lower" else spread.between(bottom, top)
    xs = [_LEFT + k * (FULL_WIDTH - _LEFT - _RIGHT) / len(axes) for k in range(len(axes) + 1)]
    columns = [_column(name, x, labels, height) for (name, labels), x in zip(axes.items(), xs, strict=False)]
    points = [_points(ordered, axis, columns[axis], height / len(columns[axis].choices)) for axis in range(len(axes))]
    paths = [
        _path(strand, place, points, xs, scale, _rank(strand, strands, better)) for place, strand in enumerate(ordered)
    ]
    return rendered(
        "parallel.svg",
        title=title,
        metric=metric,
        width=FULL_WIDTH,
        height=bottom + _BOTTOM,
        top=top,
        bottom=bottom,
        columns=columns,
        metric_x=xs[-1],
        ticks=scale.placed_ticks(),
        paths=paths,
    )


def _column(name: str, x: float, labels: Sequence[str], height: float) -> _Column:
    room = height / len(labels)
    return _Column(name, x, [PlacedTick(_TOP + room * (k + 0.5), label) for k, label in enumerate(labels)])


def _points(ordered: Sequence[Strand], axis: int, column: _Column, room: float) -> list[float]:
    """Return the height of each strand on an axis: around its choice, the better ones above."""
    places = {choice.text: choice.at for choice in column.choices}
    seen: dict[str, int] = {}
    total = {label: sum(strand.labels[axis] == label for strand in ordered) for label in places}
    found = []
    for strand in ordered:
        label = strand.labels[axis]
        rank = seen[label] = seen.get(label, 0) + 1
        found.append(places[label] + _FAN * room * (0.5 - (rank - 0.5) / total[label]))
    return found


def _path(
    strand: Strand, place: int, points: Sequence[Sequence[float]], xs: Sequence[float], scale: Scale, rank: float
) -> _Path:
    heights = [*(column[place] for column in points), scale.at(strand.value)]
    curve = f"M{xs[0]:.1f},{heights[0]:.1f}"
    for (x0, y0), (x1, y1) in pairwise(zip(xs, heights, strict=True)):
        middle = (x0 + x1) / 2
        curve += f"C{middle:.1f},{y0:.1f} {middle:.1f},{y1:.1f} {x1:.1f},{y1:.1f}"
    text = f"{strand.name}: {number(strand.value, '.4g')}"
    return _Path(text, curve, _colour(rank))


def _rank(strand: Strand, strands: Sequence[Strand], better: Better) -> float:
    """Return the share of the others that are worse, plus half of those that are equal."""
    sign = -1 if better == "lower" else 1
    worse = sum(sign * other.value < sign * strand.value for other in strands)
    equal = sum(other.value == strand.value for other in strands) - 1
    return (worse + equal / 2) / (len(strands) - 1) if len(strands) > 1 else 0.5


def _colour(share: float) -> str:
    """Return the colour of a rank from the worst, 0, to the best, 1."""
    begin, end = (_WORST, _MIDDLE) if share < 0.5 else (_MIDDLE, _BEST)
    at = 2 * share if share < 0.5 else 2 * share - 1
    return "#" + "".join(f"{round(a + at * (b - a)):02x}" for a, b in zip(begin, end, strict=True))
