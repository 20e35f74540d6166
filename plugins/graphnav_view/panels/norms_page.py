"""``norms.png``: the lengths of both independent components of one frame in order, as the paper's Fig. 3 has them."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graphnav import Components, Plane, Truth
from graphnav.arrays import Bools
from graphnav_view import style
from graphnav_view.panels.frame_rows import about_of
from graphnav_view.panels.keyframe import keyframe_utime
from graphnav_view.panels.separated import NAMES, Norms, norms_of
from graphnav_view.signals import Signals

_GROUND, _OBSTACLE, _NEITHER = "#0072b2", "#d55e00", "#8a8a8a"
_POINTS = 240
_CROWD_PERCENT = 99.5
"""Share of the vectors that the axis of the lengths shows."""
_BARS = 50
_STRIPS = "cells in ascending order of |v|; bars: share of obstacle\namong them, true and in D"
_LETTERS_PER_IN = 13
_PAGE_IN = (8.4, 4.5)
_LEFT_IN, _WIDTH_IN, _APART_IN = 0.72, 3.42, 0.72
_TOP_IN, _HEIGHT_IN, _STRIP_IN, _STEP_IN = 1.2, 2.2, 0.15, 0.2


def draw_norms(signals: Signals, path: Path) -> Path | None:
    """Draw the sorted lengths of the keyframe into ``path``; None if the log has no components of it."""
    utime = keyframe_utime(signals)
    return None if utime is None else draw_norms_at(signals, utime, path)


def draw_norms_at(signals: Signals, utime: int, path: Path) -> Path | None:
    """Draw the sorted lengths of the frame that is stamped ``utime``; None if the log has no components of it."""
    components = signals.at(Components, utime)
    if components is None:
        return None
    plane, truth = signals.at(Plane, utime), signals.at(Truth, utime)
    norms = [norms_of(components, which, plane, truth) for which in (0, 1)]
    with style.style():
        figure = norms_figure(norms, components.taken, f"Frame at {signals.at_s(utime):.2f} s", about_of(signals))
        return style.save(figure, path)


def norms_figure(both: Sequence[Norms], taken: int, headline: str, about: str) -> Figure:
    """Return the figure of both components side by side: of each the lengths, and two strips of bars below them."""
    width, height = _PAGE_IN
    figure = style.new_figure(width, height)
    shortened = textwrap.shorten(about, int(width * _LETTERS_PER_IN), placeholder=" …")
    figure.text(0.02, 1 - 0.12 / height, headline, va="top", fontsize=12, fontweight="bold")
    figure.text(0.02, 1 - 0.38 / height, shortened, va="top", fontsize=9.5, color=style.QUIET)
    for which, (norms, kind) in enumerate(zip(both, ("low variance", "high variance"), strict=True)):
        left_in = _LEFT_IN + which * (_WIDTH_IN + _APART_IN)
        axes = _axes_at(figure, left_in, _TOP_IN, _HEIGHT_IN)
        axes.set_title(f"{NAMES[which]}: {kind}{', taken' if which == taken else ''}", loc="left", pad=5)
        _draw_lengths(axes, norms)
        axes.set_ylabel("length |v|, px" if which == 0 else "")
        below_in = _TOP_IN + _HEIGHT_IN + 0.06
        _draw_strip(_axes_at(figure, left_in, below_in, _STRIP_IN), norms.is_obstacle, "true", _OBSTACLE)
        _draw_strip(_axes_at(figure, left_in, below_in + _STEP_IN, _STRIP_IN), norms.is_called, "D", "black")
        at = left_in / width, 1 - (below_in + 2 * _STEP_IN + 0.02) / height
        words = f"{_auroc_text(norms)}\n{_STRIPS}"
        figure.text(*at, words, va="top", fontsize=9, color=style.QUIET, linespacing=1.3)
    _draw_legend(figure)
    return figure


def _axes_at(figure: Figure, left_in: float, top_in: float, height_in: float) -> Axes:
    width, height = _PAGE_IN
    low = height - top_in - height_in
    return figure.add_axes((left_in / width, low / height, _WIDTH_IN / width, height_in / height))


def _draw_lengths(axes: Axes, norms: Norms) -> None:
    count = len(norms.length_px)
    top_px = 1.1 * max(float(np.percentile(norms.length_px, _CROWD_PERCENT)) if count else 0.0, 1e-6)
    place = (np.arange(count) + 0.5) / max(count, 1)
    neither = ~norms.is_ground & ~norms.is_obstacle
    for cells, colour, marker, size in (
        (neither, _NEITHER, "o", 8.0),
        (norms.is_ground, _GROUND, "o", 8.0),
        (norms.is_obstacle, _OBSTACLE, "^", 22.0),
    ):
        picked = np.arange(count)[:: max(1, count // _POINTS)]
        picked = picked[cells[picked]]
        axes.scatter(place[picked], norms.length_px[picked], s=size, color=colour, marker=marker, linewidths=0)
    axes.axhline(norms.median_px, color="black", lw=1.4, ls="--", zorder=4)
    axes.text(
        0.02,
        norms.median_px + 0.02 * top_px,
        f"median m = {norms.median_px:.3g} px",
        va="bottom",
        fontsize=9.5,
        path_effects=style.halo(),
        zorder=5,
    )
    axes.set_xlim(0, 1)
    axes.set_ylim(0, top_px)
    axes.set_xticks([])


def _draw_strip(axes: Axes, cells: Bools, name: str, colour: str) -> None:
    """Draw which share of the cells around each place of the order is obstacle, as the height of bars."""
    shares = [float(part.mean()) if len(part) else 0.0 for part in np.array_split(cells, _BARS)]
    axes.bar((np.arange(_BARS) + 0.5) / _BARS, shares, 1 / _BARS, color=colour, linewidth=0)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.set_xticks([])
    axes.set_yticks([0.5], [name], fontsize=9)
    axes.tick_params(length=0)


def _auroc_text(norms: Norms) -> str:
    of_epsilon, of_length = norms.auroc(about_median=True), norms.auroc(about_median=False)
    if of_epsilon is None or of_length is None:
        return "ground and obstacle are not both known"
    return f"AUROC of ε = ||v| − m|: {of_epsilon:.2f}, of |v|: {of_length:.2f}"


def _draw_legend(figure: Figure) -> None:
    handles = [
        figure.axes[0].scatter([], [], s=30, color=colour, marker=marker, label=label)
        for colour, marker, label in (
            (_GROUND, "o", "true ground"),
            (_OBSTACLE, "^", "true obstacle"),
            (_NEITHER, "o", "not known, or as much of both"),
        )
    ]
    height = _PAGE_IN[1]
    figure.legend(
        handles=handles,
        loc="upper left",
        bbox_to_anchor=(0.0, 1 - 0.56 / height),
        ncols=len(handles),
        frameon=False,
        fontsize=9.5,
        handletextpad=0.2,
    )
