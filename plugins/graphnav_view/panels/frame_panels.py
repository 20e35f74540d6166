"""The panels of one frame: what the log holds of it, in the order in which it was worked out."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from matplotlib.axes import Axes

from graphnav import LocalMap, Map, Scene
from graphnav_view.maps.local_map import UNKNOWN, draw_local_map
from graphnav_view.panels import camera_panels, force_panel, potential_panels
from graphnav_view.panels.keyframe import Frame
from graphnav_view.panels.panel_page import Panel
from graphnav_view.panels.scene_panel import SceneMoment, draw_scene
from graphnav_view.track import Track, is_placed

CLOUD = "cloud of gradients"
_SHOWN_M = 4.0
"""Height of the panel."""
_PX_PER_CELL = 4


def frame_panels(world: Map | None, track: Track | None, frame: Frame) -> Iterator[Panel]:
    """Yield the panels that the log is enough for: the paper's with their letters, the flow without one."""
    if world is not None and track is not None and frame.state is not None and is_placed(frame.state):
        moment = SceneMoment(Scene(world), track, frame.state, frame.time_s)
        yield Panel("scene", partial(draw_scene, moment=moment), letter="a")
    if frame.image is not None:
        yield Panel("image", partial(camera_panels.draw_image, frame=frame), letter="b")
    if frame.flow is not None:
        yield Panel("optical flow", partial(camera_panels.draw_flow, frame=frame))
    if frame.plane is not None:
        yield Panel("dominant plane", partial(camera_panels.draw_plane, frame=frame), letter="c")
    if frame.local_map is not None:
        yield Panel("local map", partial(draw_surroundings, local=frame.local_map))
    if frame.potential is not None:
        yield Panel("obstacle potential", partial(potential_panels.draw_potential, frame=frame), letter="d")
        yield Panel("gradient field", partial(potential_panels.draw_gradient, frame=frame), letter="e")
        yield Panel(CLOUD, partial(potential_panels.draw_cloud, frame=frame), letter="f")
    if frame.steering is not None:
        yield Panel("direction of attention", partial(force_panel.draw_direction, frame=frame), letter="g")


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
