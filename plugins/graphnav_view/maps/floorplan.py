"""A scene drawn into axes in metres."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import groupby

from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.transforms import Transform

from graphnav import SceneArea

Colour = str | tuple[str, float]

EDGE = "#2b2b2b"
"""Colour of the rims of bodies."""
_GOAL, _SEEN, _BODY, _SEEN_EDGE = 1.0, 1.5, 2.0, 3.0
"""From the floor up; what the camera sees lies on the floor, its outline over the bodies."""


def draw_areas(axes: Axes, areas: Iterable[SceneArea], to_axes: Transform | None = None) -> None:
    """Fill areas in the order in which they are given; ``to_axes``: from W to the axes, where they are not in W."""
    transform = axes.transData if to_axes is None else to_axes + axes.transData
    for role, group in groupby(areas, key=lambda area: area.role):
        same = list(group)
        fill: Colour = (same[0].colour, same[0].opacity_ratio)
        shapes: list[tuple[Colour, Colour, float, float]] = [(fill, EDGE, 0.5, _BODY)]
        if role == "goal":
            shapes = [(fill, fill, 1.0, _GOAL)]
        elif role == "seen":
            shapes = [(fill, "none", 0.0, _SEEN), ("none", same[0].colour, 1.4, _SEEN_EDGE)]
        for face, edgecolor, linewidth, zorder in shapes:
            drawn = PolyCollection(
                [area.outline_m for area in same],
                facecolor=face,
                edgecolor=edgecolor,
                linewidth=linewidth,
                zorder=zorder,
                transform=transform,
            )
            axes.add_collection(drawn, autolim=False)
