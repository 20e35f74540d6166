"""Profiles: the share of values that are at least so large, a falling line a variant."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from graphnav.studies.ablation.report.html.charts.lines import HALF_WIDTH
from graphnav.studies.ablation.report.html.charts.scale import Scale, scale_of
from graphnav.studies.ablation.report.html.rendering import number, rendered

_HEIGHT, _LEFT, _RIGHT, _TOP, _BOTTOM = 270.0, 42.0, 16.0, 30.0, 46.0


@dataclass(frozen=True)
class Steps:
    """The values of one variant, sorted."""

    name: str
    values: Sequence[float]
    colour: str
    is_dashed: bool = False


@dataclass(frozen=True)
class _StepLine:
    """A profile in pixels."""

    steps: Steps
    corners: Sequence[tuple[float, float]]
    text: str


def profile_chart(title: str, x_label: str, steps: Sequence[Steps]) -> Markup:
    """Return SVG of profiles of values from 0 to 1; the axis begins where the first profile falls.

    Zeros are left of it: they are failures, and a profile starts at the share of the rest.
    """
    positive = [value for one in steps for value in one.values if value > 0]
    across = scale_of(positive).between(_LEFT, HALF_WIDTH - _RIGHT)
    up = scale_of([0.0, 1.0]).between(_HEIGHT - _BOTTOM, _TOP)
    lines = [_StepLine(one, list(_corners(one.values, across, up)), _text(one)) for one in steps]
    return rendered(
        "profiles.svg",
        title=title,
        x_label=x_label,
        width=HALF_WIDTH,
        height=_HEIGHT,
        left=_LEFT,
        right=across.stop,
        top=_TOP,
        bottom=up.start,
        middle=across.middle,
        up=up.placed_ticks(),
        across=across.placed_ticks(),
        lines=lines,
    )


def _corners(values: Sequence[float], across: Scale, up: Scale) -> Iterator[tuple[float, float]]:
    """Yield the corners of the share of values that are at least as large as the place on the axis."""
    n_left = bisect_right(values, 0.0)
    share = 1 - n_left / len(values)
    yield across.at(across.low), up.at(share)
    for place, value in enumerate(values[n_left:], start=n_left + 1):
        yield across.at(value), up.at(share)
        share = 1 - place / len(values)
        yield across.at(value), up.at(share)
    yield across.at(across.high), up.at(share)


def _text(one: Steps) -> str:
    middle = one.values[(len(one.values) - 1) // 2]
    return f"{one.name}: half of {len(one.values)} runs have at least {number(middle, '.3f')}"
