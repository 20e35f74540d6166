"""``components.png``: the mixtures of one frame, the independent components, and the dominant plane made of one."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path

from graphnav import Components
from graphnav_view import style
from graphnav_view.panels import camera_panels, separation_panels
from graphnav_view.panels.keyframe import Frame, frame_at, keyframe_utime
from graphnav_view.panels.panel_page import Panel, draw_page
from graphnav_view.signals import Signals


def draw_components(signals: Signals, path: Path) -> Path | None:
    """Draw the separation of the keyframe into ``path``; None if the log has no components of it."""
    utime = keyframe_utime(signals)
    return None if utime is None else draw_separation(signals, utime, path)


def draw_separation(signals: Signals, utime: int, path: Path) -> Path | None:
    """Draw the separation of the frame that is stamped ``utime`` into ``path``; None if the log has none of it."""
    components = signals.at(Components, utime)
    if components is None:
        return None
    frame = frame_at(signals, utime)
    rows_px, cols_px = frame.shape_px
    small, large = components.variances.tolist()
    headline = (
        f"Frame at {frame.time_s:.2f} s · score from {separation_panels.NAMES[components.taken]} · "
        f"variances {small:.3g} and {large:.3g}"
    )
    about = str(signals.graph.get("about") or "").strip()
    with style.style():
        figure = draw_page(list(_panels(frame, components)), rows_px / cols_px, headline, about)
        return style.save(figure, path)


def _panels(frame: Frame, components: Components) -> Iterator[Panel]:
    if frame.image is not None:
        yield Panel("image", partial(camera_panels.draw_image, frame=frame))
    for row, title in enumerate(("optical flow u", "planar flow û")):
        draw = partial(separation_panels.draw_mixture, frame=frame, components=components, row=row)
        yield Panel(title, draw)
    yield Panel("mixing", partial(separation_panels.draw_mixing, components=components))
    for which, kind in enumerate(("low variance", "high variance")):
        taken = ", taken" if which == components.taken else ""
        draw = partial(separation_panels.draw_component, frame=frame, components=components, which=which)
        yield Panel(f"{separation_panels.NAMES[which]}: {kind}{taken}", draw)
    if frame.plane is not None:
        yield Panel("score ε", partial(separation_panels.draw_score, frame=frame, plane=frame.plane))
        yield Panel("dominant plane", partial(camera_panels.draw_plane, frame=frame))
