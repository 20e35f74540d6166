"""The panels of one frame: what the log holds of it, in the order in which it was worked out."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from graphnav import Map, Scene
from graphnav_view.panels import camera_panels, force_panel, potential_panels
from graphnav_view.panels.keyframe import Frame
from graphnav_view.panels.local_map_panel import draw_surroundings
from graphnav_view.panels.panel_page import Panel
from graphnav_view.panels.scene_panel import SceneMoment, draw_scene
from graphnav_view.track import Track, is_placed

CLOUD = "cloud of gradients"


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
