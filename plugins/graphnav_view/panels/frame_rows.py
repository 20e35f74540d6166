"""Several frames of a run in one picture: a row each, the paper's seven panels as columns."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from graphnav import Map, UserError
from graphnav_view import style
from graphnav_view.panels.frame_panels import frame_panels
from graphnav_view.panels.frame_times import frame_stamps, frame_utime
from graphnav_view.panels.keyframe import Frame, frame_at, frame_texts
from graphnav_view.panels.panel_page import Panel
from graphnav_view.signals import Signals
from graphnav_view.track import track_of

MAX_ROWS = 12

_WIDTH_IN, _GAP_IN, _SIDE_IN = 2.0, 0.12, 0.3
_HEAD_IN, _TITLE_IN, _ROW_IN, _FOOT_IN = 0.6, 0.3, 0.32, 0.16
_MIN_RATIO, _MAX_RATIO = 0.4, 1.2
_LETTERS_PER_IN = 13


def draw_rows(signals: Signals, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw the frames nearest to ``times_s`` (seconds from the start of the log); None if the log has no camera data.

    Raises
    ------
    UserError
        A time is outside the log, or there are more frames than fit into a picture.
    """
    stamps = frame_stamps(signals)
    if not stamps:
        return None
    utimes = sorted({frame_utime(signals, stamps, time_s) for time_s in times_s})
    if len(utimes) > MAX_ROWS:
        raise UserError.of(f"{len(utimes)} rows, but a picture holds at most {MAX_ROWS}", "ask for fewer frames")
    world, track = signals.first(Map), track_of(signals)
    frames = [frame_at(signals, utime) for utime in utimes]
    with style.style():
        rows = [[panel for panel in frame_panels(world, track, frame) if panel.letter] for frame in frames]
        about = str(signals.graph.get("about") or "").strip()
        return style.save(_page(frames, rows, about), file)


def _page(frames: Sequence[Frame], rows: Sequence[Sequence[Panel]], about: str) -> Figure:
    """Return the figure; a panel that only some frames have keeps its column in the others."""
    columns = {panel.letter: panel.title for panels in rows for panel in panels}
    letters = sorted(columns)
    rows_px, cols_px = frames[0].shape_px
    height = _WIDTH_IN * min(max(rows_px / cols_px, _MIN_RATIO), _MAX_RATIO)
    page_width = 2 * _SIDE_IN + len(letters) * (_WIDTH_IN + _GAP_IN) - _GAP_IN
    page_height = _HEAD_IN + _TITLE_IN + len(rows) * (_ROW_IN + height) + _FOOT_IN
    figure = style.new_figure(page_width, page_height)
    headline = textwrap.shorten(about, int(page_width * _LETTERS_PER_IN), placeholder=" …")
    figure.text(_SIDE_IN / page_width, 1 - 0.16 / page_height, headline, va="top", fontsize=12, fontweight="bold")
    for place, letter in enumerate(letters):
        at = (_SIDE_IN + place * (_WIDTH_IN + _GAP_IN)) / page_width, 1 - (_HEAD_IN + 0.04) / page_height
        figure.text(*at, f"({letter}) {columns[letter]}", va="top", fontsize=10.5, fontweight="bold")
    for line, (frame, panels) in enumerate(zip(frames, rows, strict=True)):
        top = _HEAD_IN + _TITLE_IN + line * (_ROW_IN + height)
        words = " · ".join([f"{frame.time_s:.2f} s", *frame_texts(frame)])
        figure.text(_SIDE_IN / page_width, 1 - (top + _ROW_IN - 0.06) / page_height, words, va="bottom", fontsize=9)
        for panel in panels:
            left = _SIDE_IN + letters.index(panel.letter) * (_WIDTH_IN + _GAP_IN)
            low = page_height - top - _ROW_IN - height
            box = (left / page_width, low / page_height, _WIDTH_IN / page_width, height / page_height)
            panel.draw(figure.add_axes(box))
    return figure
