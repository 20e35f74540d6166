"""The panel of a local map: what the robot knows of the floor around it."""

from __future__ import annotations

from matplotlib.axes import Axes

from graphnav import LocalMap
from graphnav_view.maps.local_map import UNKNOWN, draw_local_map

_SHOWN_M = 4.0
"""Height of the panel."""
_PX_PER_CELL = 4


def draw_surroundings(axes: Axes, local: LocalMap) -> str:
    """Draw the part of a map around the robot, x of its frame to the right and y up; return the caption."""
    rows, cols = local.state.shape
    left_m, low_m = local.origin_x_m - local.cell_m / 2, local.origin_y_m - local.cell_m / 2
    axes.imshow(
        draw_local_map(local, _PX_PER_CELL * rows, _PX_PER_CELL * cols),
        extent=(left_m, left_m + cols * local.cell_m, low_m, low_m + rows * local.cell_m),
        interpolation="nearest",
        aspect="auto",
    )
    box = axes.get_window_extent()
    half_m = _SHOWN_M / 2
    half_width_m = half_m * box.width / box.height
    axes.set_facecolor(UNKNOWN)
    axes.set_xlim(local.x_m - half_width_m, local.x_m + half_width_m)
    axes.set_ylim(local.y_m - half_m, local.y_m + half_m)
    axes.set_xticks([])
    axes.set_yticks([])
    colors = "white: free; gray: unknown; red: obstacle; orange:\nmoving"
    return f"{colors}; {_SHOWN_M:g} m high, heading of the start to the right"
