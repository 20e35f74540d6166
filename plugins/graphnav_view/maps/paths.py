"""Draw the paths of several runs over the map of their common world."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from graphnav import Map, Scene
from graphnav_view import style
from graphnav_view.maps.floorplan import draw_areas
from graphnav_view.maps.map_panel import show_all
from graphnav_view.signals import Signals
from graphnav_view.track import Track, track_of

if TYPE_CHECKING:
    from graphnav import Recording


_LONG_SIDE_IN, _SHORTEST_SIDE_IN = 4.2, 1.4
_MARGIN_M = 0.15
_WIDEST, _NARROWEST = 6.0, 1.5
"""Widths of the lowest and the uppermost path, so that paths that coincide all show."""


def draw_paths(recordings: Mapping[str, Recording], colours: Mapping[str, str], file: Path) -> Path | None:
    """Draw the map of the first log that has one with the paths of all; None if no log has both."""
    signals = {name: Signals(recording) for name, recording in recordings.items()}
    world = next((found for of in signals.values() if (found := of.first(Map)) is not None), None)
    tracks = {name: track for name, of in signals.items() if (track := track_of(of)) is not None}
    if world is None or not tracks:
        return None
    scene, first = Scene(world), next(iter(tracks.values()))
    low, high = scene.bounds_m([track.pose[:, :2] for track in tracks.values()], first.moving[:1], _MARGIN_M)
    width, height = np.maximum((high - low) * (_LONG_SIDE_IN / float((high - low).max())), _SHORTEST_SIDE_IN)
    with style.style():
        figure = style.new_figure(width, height)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        show_all(axes, low, high)
        axes.spines[:].set_visible(False)
        draw_areas(axes, [*scene.fixed, *scene.moving_at(first.moving[0])])
        for place, (name, track) in enumerate(tracks.items(), 1):
            width = _WIDEST - (_WIDEST - _NARROWEST) * place / len(tracks)
            axes.plot(*track.pose[:, :2].T, color=colours[name], lw=width, zorder=4, solid_capstyle="round")
            axes.plot(*track.pose[-1, :2], marker="o", ms=5, mfc="white", mec=colours[name], mew=1.6, zorder=6)
        for name, track in tracks.items():
            _mark_contact(axes, scene, track, colours[name])
        axes.plot(*first.pose[0, :2], marker="o", ms=6, color="black", zorder=8)
        return style.save(figure, file)


def _mark_contact(axes: Axes, scene: Scene, track: Track, colour: str) -> None:
    """Mark a contact at the end of a path by a cross in the path's colour."""
    if track.last.contact:
        touched = scene.nearest_point(track.last.moving, track.pose[-1, :2])
        axes.plot(*touched, marker="X", ms=11, color=colour, mec="white", zorder=7)
