"""A contact sheet: small frames of a run at regular times, side by side."""

from __future__ import annotations

import math
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch

from graphnav import UserError
from graphnav.arrays import Doubles
from graphnav_view import style
from graphnav_view.flow_colour import flow_rgb, flow_scale_px
from graphnav_view.outcome import outcome_text
from graphnav_view.panels.frame_times import frame_stamps, nearest
from graphnav_view.panels.keyframe import Frame, frame_at, theta_text
from graphnav_view.signals import Signals
from graphnav_view.track import track_of
from graphnav_view.video.camera_tiles import Stretch, camera_rgb, plane_tile

MAX_FRAMES = 200

_WIDTH_IN, _GAP_IN, _SIDE_IN = 1.7, 0.14, 0.3
_HEAD_IN, _TITLE_IN, _FOOT_IN = 0.62, 0.2, 0.42
_MIN_RATIO, _MAX_RATIO = 0.4, 1.2
_MIN_COLUMNS, _MAX_COLUMNS = 5, 10
_COLS_PX = 320
_ARROW_RATIO = 0.38
"""Length of a control force of 1, as a share of the picture's shorter side."""
_LETTERS_PER_IN = 13
_LEGEND = "obstacle red, unknown violet, rim dark; yellow: control force, up is forward; red rim: contact"


def draw_sheet(signals: Signals, every_s: float, from_s: float, until_s: float, file: Path) -> Path | None:
    """Draw a frame every ``every_s`` seconds into ``file``; None if the log has no camera data.

    Raises
    ------
    UserError
        The span has no frames, or too many for a sheet.
    """
    stamps = frame_stamps(signals)
    if not stamps:
        return None
    utimes = _utimes(signals, stamps, every_s, from_s, until_s)
    first = frame_at(signals, utimes[0])
    rows_px, cols_px = first.shape_px
    height = _WIDTH_IN * min(max(rows_px / cols_px, _MIN_RATIO), _MAX_RATIO)
    columns = min(max(_MIN_COLUMNS, math.ceil(math.sqrt(len(utimes) * 1.4))), _MAX_COLUMNS, max(len(utimes), 3))
    lines = -(-len(utimes) // columns)
    page_width = 2 * _SIDE_IN + columns * (_WIDTH_IN + _GAP_IN) - _GAP_IN
    page_height = _HEAD_IN + lines * (_TITLE_IN + height + _GAP_IN) + _FOOT_IN
    with style.style():
        figure = style.new_figure(page_width, page_height)
        about = textwrap.shorten(
            str(signals.graph.get("about") or "").strip(), int(page_width * _LETTERS_PER_IN), placeholder=" …"
        )
        left = _SIDE_IN / page_width
        figure.text(left, 1 - 0.12 / page_height, _headline(signals, every_s), va="top", fontsize=12, fontweight="bold")
        figure.text(left, 1 - 0.36 / page_height, about, va="top", fontsize=9.5, color=style.QUIET)
        figure.text(left, 0.14 / page_height, _LEGEND, va="bottom", fontsize=8.6, color=style.QUIET)
        for place, utime in enumerate(utimes):
            line, column = divmod(place, columns)
            low = _HEAD_IN + line * (_TITLE_IN + height + _GAP_IN) + _TITLE_IN + height
            left_in, low_in = _SIDE_IN + column * (_WIDTH_IN + _GAP_IN), page_height - low
            box = (left_in / page_width, low_in / page_height, _WIDTH_IN / page_width, height / page_height)
            axes = figure.add_axes(box)
            _draw(axes, frame_at(signals, utime))
        return style.save(figure, file)


def _utimes(signals: Signals, stamps: list[int], every_s: float, from_s: float, until_s: float) -> list[int]:
    """Return the stamps of the frames to draw, ascending."""
    inside = [utime for utime in stamps if from_s <= signals.at_s(utime) <= until_s]
    if not inside:
        first_s, last_s = signals.at_s(stamps[0]), signals.at_s(stamps[-1])
        raise UserError.of(
            "there are no frames in this span", f"the log has frames from {first_s:.2f} s to {last_s:.2f} s"
        )
    begin_s, span_s = signals.at_s(inside[0]), signals.at_s(inside[-1]) - signals.at_s(inside[0])
    count = math.floor(span_s / every_s + 1e-6) + 1
    if min(count, len(inside)) > MAX_FRAMES:
        step_s = span_s / (MAX_FRAMES - 1)
        digit = 10.0 ** (math.floor(math.log10(step_s)) - 1)
        raise UserError.of(
            f"a frame every {every_s:g} s gives {count} frames, but a sheet holds at most {MAX_FRAMES}",
            f"write --every {math.ceil(step_s / digit) * digit:.2g}s or more, or shorten the span: --from, --until",
        )
    if count >= len(inside):
        return inside
    times_s = begin_s + every_s * np.arange(count)
    return sorted({nearest(inside, round(signals.begin_us + time_s * 1e6)) for time_s in times_s.tolist()})


def _headline(signals: Signals, every_s: float) -> str:
    track = track_of(signals)
    words = [] if track is None else [outcome_text(signals.graph, track.last, float(track.time_s[-1]))]
    words += [] if signals.seed is None else [f"seed {signals.seed}"]
    return " · ".join([*words, f"a frame every {every_s:g} s"])


def _draw(axes: Axes, frame: Frame) -> None:
    """Draw one small frame: the dominant plane over the picture and the control force, the time above."""
    rows, cols = frame.shape_px
    axes.imshow(
        _picture(frame), extent=(-0.5, cols - 0.5, rows - 0.5, -0.5), interpolation="antialiased", aspect="auto"
    )
    axes.set_xlim(-0.5, cols - 0.5)
    axes.set_ylim(rows - 0.5, -0.5)
    axes.set_xticks([])
    axes.set_yticks([])
    axes.set_title(f"{frame.time_s:.2f} s", loc="left", pad=2.5, fontsize=8.5)
    if frame.steering is not None:
        axes.set_title(
            f"θ {theta_text(frame.steering.theta_rad)}", loc="right", pad=2.5, fontsize=8.5, fontweight="normal"
        )
        _arrow(axes, frame.steering.control, rows, cols)
    if frame.state is not None and frame.state.contact:
        axes.spines[:].set(color=style.CONTACT, linewidth=3.0)


def _arrow(axes: Axes, control: Doubles, rows: int, cols: int) -> None:
    length = float(np.hypot(*control))
    if not 0 < length < math.inf:
        return
    start = np.array([cols, rows]) / 2 - 0.5
    end = start + np.array([1.0, -1.0]) * control / max(length, 1.0) * _ARROW_RATIO * min(rows, cols)
    for colour, width in (("black", 3.6), (style.CONTROL, 2.0)):
        axes.add_patch(
            FancyArrowPatch(
                tuple(start),
                tuple(end),
                arrowstyle="-|>",
                mutation_scale=9,
                shrinkA=0,
                shrinkB=0,
                color=colour,
                lw=width,
            )
        )


def _picture(frame: Frame) -> npt.NDArray[Any]:
    """Return the plane over the image, else the image, else the flow in colour."""
    rows, cols = frame.shape_px
    stretch = Stretch(rows, cols, max(1, round(_COLS_PX * rows / cols)), _COLS_PX)
    camera = None if frame.image is None else camera_rgb(stretch, frame.image)
    if frame.plane is not None:
        return plane_tile(stretch, camera, frame.plane, with_legend=False)
    if camera is not None:
        return stretch.placed(camera)
    if frame.flow is not None:
        return flow_rgb(frame.flow.uv_px, frame.flow.valid, flow_scale_px(frame.flow.uv_px, frame.flow.valid))
    return stretch.blank()
