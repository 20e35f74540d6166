"""``panels.png``: the paper's seven panels of one frame, and the flow that they come from."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from graphnav import Map
from graphnav_view import fields, forces, ink, sights
from graphnav_view.page import Panel, draw_page
from graphnav_view.scene import Scene, draw_scene
from graphnav_view.signals import Signals
from graphnav_view.telling import Frame, frame_at, frame_texts, telling_utime
from graphnav_view.track import track_of


def draw_panels(signals: Signals, path: Path) -> Path | None:
    """Draw the panels of the telling frame into ``path``; None where the log holds nothing that a camera saw.

    A panel whose message the log lacks is left out; the others keep their letters.
    """
    utime = telling_utime(signals)
    if utime is None:
        return None
    frame = frame_at(signals, utime)
    rows_px, cols_px = frame.shape_px
    about = str(signals.graph.get("about") or "").strip()
    with ink.style():
        figure = draw_page(list(_panels(signals, frame)), rows_px / cols_px, _headline(frame), about)
        return ink.save(figure, path)


def _headline(frame: Frame) -> str:
    return " · ".join([f"Frame at {frame.utime / 1e6:.2f} s", *frame_texts(frame)])


def _panels(signals: Signals, frame: Frame) -> Iterator[Panel]:
    """Yield the panels that the log is enough for: the paper's with their letters, the flow without one."""
    world, track = signals.first(Map), track_of(signals)
    if world is not None and track is not None and frame.state is not None:
        scene = Scene(world, track, frame.state, frame.utime / 1e6)
        yield Panel("(a) scene", partial(draw_scene, scene=scene))
    if frame.image is not None:
        yield Panel("(b) image", partial(sights.draw_image, frame=frame))
    if frame.flow is not None:
        yield Panel("optical flow", partial(sights.draw_flow, frame=frame))
    if frame.plane is not None:
        yield Panel("(c) dominant plane", partial(sights.draw_plane, frame=frame))
    if frame.potential is not None:
        yield Panel("(d) obstacle potential", partial(fields.draw_potential, frame=frame))
        yield Panel("(e) gradient field", partial(fields.draw_gradient, frame=frame))
        yield Panel("(f) cloud of gradients", partial(fields.draw_cloud, frame=frame))
    if frame.steering is not None:
        yield Panel("(g) direction of attention", partial(forces.draw_direction, frame=frame))
