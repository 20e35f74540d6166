"""The separation of several frames in one picture, a row each, as the paper's Fig. 8 has them: I, u, v, D."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path
from statistics import median
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graphnav import Components, Truth, UserError
from graphnav_view import style
from graphnav_view.flow_colour import flow_scale_px
from graphnav_view.panels import camera_panels
from graphnav_view.panels.camera_panels import Field, show_vectors
from graphnav_view.panels.frame_rows import Column, about_of, draw_grid, requested_utimes
from graphnav_view.panels.keyframe import Frame, frame_at
from graphnav_view.panels.panel_page import Panel
from graphnav_view.panels.separated import component_px, kinds_of
from graphnav_view.signals import Signals


class _Row(NamedTuple):
    """A frame, its flow u and its component v in pixels, and the true share of obstacle; None for missing ones."""

    frame: Frame
    u: Field | None
    v: Field | None
    true_ratio: float | None


def draw_separation_rows(signals: Signals, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw the frames nearest to ``times_s`` (seconds from the start of the log); None if the log has no camera data.

    Raises
    ------
    UserError
        The log has no independent components, a time is outside it, or there are too many frames for a picture.
    """
    utimes = requested_utimes(signals, times_s)
    if not utimes:
        return None
    if not signals.stamps(Components):
        raise UserError.of(
            "the log has no independent components: plane.ica publishes them where a stage reads them",
            "run the graph with --set components+=score.components",
        )
    with style.style():
        return style.save(separation_figure(signals, utimes), file)


def separation_figure(signals: Signals, utimes: Sequence[int]) -> Figure:
    """Return the figure of the frames of these stamps; a panel that a frame has no data for is left out."""
    rows = [_row_at(signals, utime) for utime in utimes]
    u_px, v_px = _full_px(row.u for row in rows), _full_px(row.v for row in rows)
    columns = {
        "I": Column("I: image"),
        "u": Column("u: optical flow", f"full colour and arrow from {u_px:.2g} px"),
        "v": Column("v: component taken", f"full colour and arrow from {v_px:.2g} px"),
        "D": Column("D: dominant plane", "black: obstacle; hatched: not judged"),
    }
    panels = [_panels(row, u_px, v_px, with_wheel=row is rows[0]) for row in rows]
    return draw_grid(columns, panels, [_words(row) for row in rows], rows[0].frame.shape_px, about_of(signals))


def _row_at(signals: Signals, utime: int) -> _Row:
    frame, components = frame_at(signals, utime), signals.at(Components, utime)
    flow, plane = frame.flow, frame.plane
    return _Row(
        frame,
        None if flow is None else Field(flow.uv_px, flow.valid, flow.step_px),
        None if components is None else component_px(components, components.taken),
        None if plane is None else kinds_of(signals.at(Truth, utime), plane).obstacle_ratio(plane.valid),
    )


def _full_px(fields: Iterable[Field | None]) -> float:
    """Return the length in full colour for all rows: that of the middle one, so that one frame does not decide it."""
    return median([flow_scale_px(field.uv, field.valid) for field in fields if field is not None] or [0.0])


def _panels(row: _Row, u_px: float, v_px: float, *, with_wheel: bool) -> list[Panel]:
    draw = partial(_draw_field, frame=row.frame, with_wheel=with_wheel)
    drawn: dict[str, Callable[[Axes], str] | None] = {
        "I": None if row.frame.image is None else partial(camera_panels.draw_image, frame=row.frame),
        "u": None if row.u is None else partial(draw, field=row.u, full_px=u_px),
        "v": None if row.v is None else partial(draw, field=row.v, full_px=v_px),
        "D": None if row.frame.plane is None else partial(camera_panels.draw_plane, frame=row.frame),
    }
    return [Panel("", panel, letter) for letter, panel in drawn.items() if panel is not None]


def _draw_field(axes: Axes, frame: Frame, field: Field, full_px: float, *, with_wheel: bool) -> str:
    show_vectors(axes, frame, field, full_px, with_wheel=with_wheel)
    return ""


def _words(row: _Row) -> str:
    words = [f"{row.frame.time_s:.2f} s"]
    words += [] if row.frame.plane is None else [f"obstacle in D {row.frame.plane.obstacle_ratio:.0%}"]
    words += [] if row.true_ratio is None else [f"true obstacle {row.true_ratio:.0%}"]
    return " · ".join(words)
