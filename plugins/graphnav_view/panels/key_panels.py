"""``panels.png``: the paper's seven panels of one frame, and the flow from which they derive."""

from __future__ import annotations

from pathlib import Path

from graphnav import Map
from graphnav_view import style
from graphnav_view.panels.frame_panels import frame_panels
from graphnav_view.panels.keyframe import Frame, frame_at, frame_texts, keyframe_utime
from graphnav_view.panels.panel_page import draw_page
from graphnav_view.signals import Signals
from graphnav_view.track import track_of


def draw_panels(signals: Signals, path: Path) -> Path | None:
    """Draw the panels of the keyframe into ``path``; None if the log has no camera data.

    Panels without data are omitted; the others keep their letters.
    """
    utime = keyframe_utime(signals)
    return None if utime is None else draw_frame(signals, utime, path)


def draw_frame(signals: Signals, utime: int, path: Path) -> Path:
    """Draw the panels of the frame that is stamped ``utime`` into ``path``."""
    frame = frame_at(signals, utime)
    rows_px, cols_px = frame.shape_px
    about = str(signals.graph.get("about") or "").strip()
    with style.style():
        panels = list(frame_panels(signals.first(Map), track_of(signals), frame))
        figure = draw_page(panels, rows_px / cols_px, _headline(frame), about)
        return style.save(figure, path)


def _headline(frame: Frame) -> str:
    return " · ".join([f"Frame at {frame.time_s:.2f} s", *frame_texts(frame)])
