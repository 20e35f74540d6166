"""``map.png``: the world from above and the robot's path, coloured by time."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerPatch
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, FancyArrowPatch, Patch, Polygon
from matplotlib.ticker import MaxNLocator

from graphnav import Map, Scene
from graphnav_view import style
from graphnav_view.maps.floorplan import EDGE, draw_areas
from graphnav_view.outcome import drive_texts, outcome_text
from graphnav_view.signals import Signals
from graphnav_view.track import Track, track_of

_LONG_SIDE_IN = 7.0
_SHORTEST_SIDE_IN = 2.6
_LEFT_IN, _RIGHT_IN, _TOP_IN, _BOTTOM_IN = 0.75, 1.15, 0.95, 1.15
_MIN_WIDTH_IN = 6.6
_LETTERS_PER_IN = 15
_MARGIN_M = 0.3
_LABELS = {"wall": "wall", "obstacle": "obstacle", "moving": "moving obstacle", "goal": "goal region"}
"""In the legend, by role."""
_TIMES = 6
"""Number of drawn positions of a moving obstacle."""


def draw_overview(signals: Signals, path: Path) -> Path | None:
    """Draw the map with the path into ``path``; None if the log has no map or no states."""
    world, track = signals.first(Map), track_of(signals)
    if world is None or track is None:
        return None
    with style.style():
        scene = Scene(world)
        figure, axes = _page(scene, track)
        draw_areas(axes, scene.fixed)
        norm = Normalize(0.0, max(float(track.time_s[-1]), 1e-3))
        _draw_moving(axes, scene, track, norm)
        _draw_path(axes, track, norm)
        _draw_ends(axes, scene, track)
        _colourbar(figure, axes, norm)
        _title(figure, signals, world, track)
        _legend(figure, scene, track)
        return style.save(figure, path)


def _page(scene: Scene, track: Track) -> tuple[Figure, Axes]:
    """Return a figure whose axes have the shape of their content."""
    low, high = scene.bounds_m([track.pose[:, :2]], track.moving, _MARGIN_M)
    per_m = _LONG_SIDE_IN / float((high - low).max())
    width, height = np.maximum((high - low) * per_m, _SHORTEST_SIDE_IN)
    page_width = max(_LEFT_IN + width + _RIGHT_IN, _MIN_WIDTH_IN)
    page_height = _BOTTOM_IN + height + _TOP_IN
    figure = style.new_figure(page_width, page_height)
    left = (page_width - width - _LEFT_IN - _RIGHT_IN) / 2 + _LEFT_IN
    axes = figure.add_axes(
        (left / page_width, _BOTTOM_IN / page_height, width / page_width, height / page_height), facecolor=style.FLOOR
    )
    middle, half = (low + high) / 2, np.array([width, height]) / per_m / 2
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_aspect("equal")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y [m]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(nbins=9, steps=[1, 2, 5, 10]))
    axes.grid(visible=True, color="#dcdad3", linewidth=0.6)
    axes.set_axisbelow(True)
    return figure, axes


def _draw_path(axes: Axes, track: Track, norm: Normalize) -> None:
    xy = track.pose[:, :2]
    if len(xy) < 2:
        return
    pieces = np.stack([xy[:-1], xy[1:]], axis=1)
    under = LineCollection(list(pieces), colors="white", linewidths=5.0, capstyle="round", zorder=4)
    over = LineCollection(list(pieces), cmap=style.PATH, norm=norm, linewidths=3.2, capstyle="round", zorder=5)
    over.set_array((track.time_s[:-1] + track.time_s[1:]) / 2)
    axes.add_collection(under, autolim=False)
    axes.add_collection(over, autolim=False)


def _draw_moving(axes: Axes, scene: Scene, track: Track, norm: Normalize) -> None:
    """Draw moving obstacles at evenly spaced times, outlined in the colour of the time."""
    times = np.unique(np.linspace(0, len(track.time_s) - 1, _TIMES).round().astype(int))
    for index, area in enumerate(scene.moving[: track.moving.shape[1]]):
        if area is None:
            continue
        bodies = PolyCollection(
            [area.at(track.moving[k, index]).outline_m for k in times],
            facecolor=(area.colour, 0.25),
            edgecolor=ScalarMappable(norm, style.PATH).to_rgba(track.time_s[times]),
            linewidth=1.8,
            zorder=3,
        )
        axes.add_collection(bodies, autolim=False)


def _draw_ends(axes: Axes, scene: Scene, track: Track) -> None:
    radius = scene.robot_radius_m
    arrow_m = max(2.2 * radius, 0.04 * float(np.ptp(axes.get_xlim())))
    x, y, yaw = scene.start
    tip = (x + arrow_m * math.cos(yaw), y + arrow_m * math.sin(yaw))
    axes.add_patch(
        FancyArrowPatch(
            (x, y), tip, arrowstyle="-|>", mutation_scale=15, shrinkA=0, shrinkB=0, color=style.ROBOT, lw=2.0, zorder=7
        )
    )
    axes.plot([x], [y], marker="o", markersize=6, color=style.ROBOT, zorder=7)
    x, y, yaw = track.pose[-1]
    looks: dict[str, Any] = {"facecolor": (1, 1, 1, 0.55), "edgecolor": style.ROBOT, "lw": 1.6, "zorder": 6}
    if scene.robot is None:
        axes.add_patch(Circle((x, y), radius, **looks))
    else:
        axes.add_patch(Polygon(scene.robot.at(track.pose[-1]).outline_m, **looks))
    axes.plot([x, x + radius * math.cos(yaw)], [y, y + radius * math.sin(yaw)], color=style.ROBOT, lw=1.6, zorder=6)
    if track.last.contact:
        touched = scene.nearest_point(track.last.moving, track.pose[-1, :2])
        axes.plot(*touched, marker="X", markersize=13, color=style.CONTACT, markeredgecolor="white", zorder=8)


def _colourbar(figure: Figure, axes: Axes, norm: Normalize) -> None:
    box = axes.get_position()
    width = 0.16 / figure.get_figwidth()
    height = min(box.height, 3.6 / figure.get_figheight())
    place = (box.x1 + 0.18 / figure.get_figwidth(), box.y0 + (box.height - height) / 2, width, height)
    bar = figure.colorbar(ScalarMappable(norm, style.PATH), cax=figure.add_axes(place))
    bar.set_label("time [s]")
    bar.locator = MaxNLocator(nbins=6, steps=[1, 2, 5, 10])
    bar.update_ticks()


def _title(figure: Figure, signals: Signals, world: Map, track: Track) -> None:
    height = figure.get_figheight()
    end_s = float(track.time_s[-1])
    facts = [] if signals.seed is None else [f"seed {signals.seed}"]
    facts += drive_texts(world, track)
    about = str(signals.graph.get("about") or "").strip()
    columns = int(figure.get_figwidth() * _LETTERS_PER_IN)
    figure.text(
        0.5,
        1 - 0.13 / height,
        outcome_text(signals.graph, track.last, end_s),
        ha="center",
        va="top",
        fontsize=13,
        fontweight="bold",
    )
    figure.text(0.5, 1 - 0.40 / height, " · ".join(facts), ha="center", va="top", fontsize=9.5)
    about = "\n".join(textwrap.wrap(about, columns, max_lines=2, placeholder=" …"))
    figure.text(0.5, 1 - 0.60 / height, about, ha="center", va="top", fontsize=9, color=style.QUIET)


class _ArrowKey(HandlerPatch):
    """Shows an arrow in a legend as an arrow."""

    def create_artists(self, *of: Any) -> list[Artist]:
        _, _, x, y, width, height, _, trans = of
        middle = y + height / 2
        return [
            FancyArrowPatch(
                (x, middle),
                (x + width, middle),
                arrowstyle="-|>",
                mutation_scale=12,
                shrinkA=0,
                shrinkB=0,
                color=style.ROBOT,
                lw=2.0,
                transform=trans,
            )
        ]


def _legend(figure: Figure, scene: Scene, track: Track) -> None:
    start = FancyArrowPatch((0, 0), (1, 0), label="start")
    keys: list[Patch | Line2D] = [start]
    shown = {area.role: area for area in (*scene.fixed, *scene.moving) if area is not None}
    for role, label in _LABELS.items():
        if (area := shown.get(role)) is not None:
            fill = (area.colour, area.opacity_ratio)
            keys.append(Patch(facecolor=fill, edgecolor=fill if role == "goal" else EDGE, lw=0.5, label=label))
    body = "o" if scene.robot is None else "s"
    keys.append(
        Line2D([], [], ls="", marker=body, ms=10, mfc="white", mec=style.ROBOT, mew=1.6, label="robot at the end")
    )
    if track.last.contact:
        keys.append(Line2D([], [], ls="", marker="X", ms=11, color=style.CONTACT, mec="white", label="contact"))
    lines = math.ceil(len(keys) / int(figure.get_figwidth() / 1.3))
    columns = math.ceil(len(keys) / lines)
    figure.legend(
        handles=keys,
        loc="lower center",
        ncols=columns,
        frameon=False,
        fontsize=9,
        bbox_to_anchor=(0.5, 0.04 / figure.get_figheight()),
        handler_map={start: _ArrowKey()},
        columnspacing=1.4,
        handlelength=1.8,
    )
