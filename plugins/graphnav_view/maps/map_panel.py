"""The panel of the entire world from above, with the robot's path."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from graphnav import Scene
from graphnav.arrays import Doubles
from graphnav_view import style
from graphnav_view.maps.floorplan import draw_areas
from graphnav_view.track import Track

_MARGIN_M = 0.15


def draw_world(axes: Axes, scene: Scene, track: Track) -> str:
    """Draw the world, the final positions of moving obstacles, and the path; return the caption."""
    show_all(axes, *scene.bounds_m([track.pose[:, :2]], track.moving[-1:], _MARGIN_M))
    draw_areas(axes, [*scene.fixed, *scene.moving_at(track.moving[-1])])
    axes.plot(*track.pose[:, :2].T, color=style.ROBOT, lw=2.0, zorder=4, solid_capstyle="round")
    draw_ends(axes, scene, track, style.ROBOT)
    driven = f"driven {track.length_m:.1f} m in {track.time_s[-1]:.1f} s"
    return f"{driven}; dot: start" + (", cross: contact" if track.last.contact else "")


def draw_ends(axes: Axes, scene: Scene, track: Track, colour: str) -> None:
    """Mark the start of a path by a dot, and its end by a cross for a contact, else by a ring."""
    axes.plot(*track.pose[0, :2], marker="o", markersize=5, color=colour, zorder=6)
    if track.last.contact:
        touched = scene.nearest_point(track.last.moving, track.pose[-1, :2])
        axes.plot(*touched, marker="X", markersize=10, color=style.CONTACT, markeredgecolor="white", zorder=8)
    else:
        axes.plot(*track.pose[-1, :2], marker="o", markersize=6, mfc="white", mec=colour, mew=1.6, zorder=7)


def show_all(axes: Axes, low: Doubles, high: Doubles) -> None:
    """Show the rectangle from ``low`` to ``high`` in W with equal scales in the shape of the axes, without ticks."""
    box = axes.get_window_extent()
    per_m = float(np.min(np.array([box.width, box.height]) / (high - low)))
    middle, half = (low + high) / 2, np.array([box.width, box.height]) / per_m / 2
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    axes.set_facecolor(style.FLOOR)
    axes.set_xticks([])
    axes.set_yticks([])
