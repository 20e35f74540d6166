"""Draw the end of a run: the map with the entire path, and the panels of the last frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import Flow, Image, Map, Plane, Scene, State
from graphnav_view import style
from graphnav_view.maps.map_panel import draw_world
from graphnav_view.outcome import outcome_text
from graphnav_view.panels.frame_panels import CLOUD, frame_panels
from graphnav_view.panels.keyframe import Frame, frame_at, frame_texts
from graphnav_view.panels.panel_page import Panel, draw_page
from graphnav_view.signals import Signals
from graphnav_view.track import Track, track_of

if TYPE_CHECKING:
    from graphnav import Recording


_END_US = 1_000_000
"""Maximum age of the last frame at the end of a run."""


def draw_ending(recording: Recording, file: Path) -> Path | None:
    """Draw the end of a run into ``file``; None if the log has neither a map nor camera data."""
    signals = Signals(recording)
    world, track = signals.first(Map), track_of(signals)
    utime = _last_utime(signals)
    if utime is None:
        return None
    frame = frame_at(signals, utime)
    rows_px, cols_px = frame.shape_px
    about = str(signals.graph.get("about") or "").strip()
    with style.style():
        panels = list(_panels(world, track, frame))
        if not panels:
            return None
        return style.save(draw_page(panels, rows_px / cols_px, _headline(signals, track, frame), about), file)


def _last_utime(signals: Signals) -> int | None:
    """Return the stamp of the last plane, else flow, image or state.

    Camera data count only if they end with the run: a log of small messages has only the first of each large one.
    """
    states = signals.stamps(State)
    for kind in (Plane, Flow, Image, State):
        stamps = signals.stamps(kind)
        if stamps and (not states or stamps[-1] >= states[-1] - _END_US):
            return stamps[-1]
    return None


def _headline(signals: Signals, track: Track | None, frame: Frame) -> str:
    words = [] if track is None else [outcome_text(signals.graph, track.last, float(track.time_s[-1]))]
    words += [] if signals.seed is None else [f"seed {signals.seed}"]
    return " · ".join([*words, f"frame at {frame.time_s:.2f} s", *frame_texts(frame)])


def _panels(world: Map | None, track: Track | None, frame: Frame) -> Iterator[Panel]:
    """Yield the panels that the log has data for, without the paper's letters and its cloud of gradients."""
    if world is not None and track is not None:
        yield Panel("entire path", partial(draw_world, scene=Scene(world), track=track))
    for panel in frame_panels(world, track, frame):
        if panel.title != CLOUD:
            yield replace(panel, letter="")
