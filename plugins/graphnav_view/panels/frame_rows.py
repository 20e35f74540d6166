"""Several frames of a run in one picture: a row each, the paper's seven panels as columns."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from graphnav import Map, UserError
from graphnav_view import style
from graphnav_view.panels.frame_panels import frame_panels
from graphnav_view.panels.frame_times import frame_stamps, frame_utime
from graphnav_view.panels.keyframe import frame_at, frame_texts
from graphnav_view.panels.panel_page import Panel
from graphnav_view.signals import Signals
from graphnav_view.track import track_of

MAX_ROWS = 12

_WIDTH_IN, _GAP_IN, _SIDE_IN = 2.0, 0.12, 0.3
_HEAD_IN, _TITLE_IN, _NOTE_IN, _ROW_IN, _FOOT_IN = 0.6, 0.3, 0.18, 0.32, 0.16
_MIN_RATIO, _MAX_RATIO = 0.4, 1.2
_LETTERS_PER_IN = 9.5


def draw_rows(signals: Signals, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw the frames nearest to ``times_s`` (seconds from the start of the log); None if the log has no camera data.

    Raises
    ------
    UserError
        A time is outside the log, or there are more frames than fit into a picture.
    """
    utimes = requested_utimes(signals, times_s)
    if not utimes:
        return None
    world, track = signals.first(Map), track_of(signals)
    frames = [frame_at(signals, utime) for utime in utimes]
    with style.style():
        rows = [[panel for panel in frame_panels(world, track, frame) if panel.letter] for frame in frames]
        titles = {panel.letter: panel.title for panels in rows for panel in panels}
        columns = {letter: Column(f"({letter}) {titles[letter]}") for letter in sorted(titles)}
        words = [" · ".join([f"{frame.time_s:.2f} s", *frame_texts(frame)]) for frame in frames]
        return style.save(draw_grid(columns, rows, words, frames[0].shape_px, about_of(signals)), file)


def requested_utimes(signals: Signals, times_s: Sequence[float]) -> list[int]:
    """Return the stamps of the frames nearest to ``times_s``, ascending; none if the log has no camera data.

    Raises UserError for a time outside the log, and for more frames than fit into a picture.
    """
    stamps = frame_stamps(signals)
    utimes = sorted({frame_utime(signals, stamps, time_s) for time_s in times_s}) if stamps else []
    if len(utimes) > MAX_ROWS:
        raise UserError.of(f"{len(utimes)} rows, but a picture holds at most {MAX_ROWS}", "ask for fewer frames")
    return utimes


def about_of(signals: Signals) -> str:
    """Return what the graph says of itself."""
    return str(signals.graph.get("about") or "").strip()


class Column(NamedTuple):
    """The title of a column, and a smaller line below it."""

    title: str
    note: str = ""


def draw_grid(
    columns: Mapping[str, Column],
    rows: Sequence[Sequence[Panel]],
    words: Sequence[str],
    shape_px: tuple[int, int],
    about: str,
) -> Figure:
    """Return the figure; a panel stands in the column of its letter, and where a frame has none, that stays empty.

    ``words``: of each row, above it. ``shape_px``: of the panels, rows and columns.
    """
    rows_px, cols_px = shape_px
    height = _WIDTH_IN * min(max(rows_px / cols_px, _MIN_RATIO), _MAX_RATIO)
    title_in = _TITLE_IN + (_NOTE_IN if any(column.note for column in columns.values()) else 0.0)
    page_width = 2 * _SIDE_IN + len(columns) * (_WIDTH_IN + _GAP_IN) - _GAP_IN
    page_height = _HEAD_IN + title_in + len(rows) * (_ROW_IN + height) + _FOOT_IN
    figure = style.new_figure(page_width, page_height)
    letters = int((page_width - 2 * _SIDE_IN) * _LETTERS_PER_IN)
    headline = textwrap.fill(about, letters, max_lines=2, placeholder=" …")
    figure.text(_SIDE_IN / page_width, 1 - 0.16 / page_height, headline, va="top", fontsize=12, fontweight="bold")
    left_in = {letter: _SIDE_IN + place * (_WIDTH_IN + _GAP_IN) for place, letter in enumerate(columns)}
    for letter, column in columns.items():
        left, top = left_in[letter] / page_width, _HEAD_IN + 0.04
        figure.text(left, 1 - top / page_height, column.title, va="top", fontsize=10.5, fontweight="bold")
        below = 1 - (top + _NOTE_IN + 0.03) / page_height
        figure.text(left, below, column.note, va="top", fontsize=8.6, color=style.QUIET)
    for line, (text, panels) in enumerate(zip(words, rows, strict=True)):
        top = _HEAD_IN + title_in + line * (_ROW_IN + height)
        figure.text(_SIDE_IN / page_width, 1 - (top + _ROW_IN - 0.06) / page_height, text, va="bottom", fontsize=9)
        for panel in panels:
            low = page_height - top - _ROW_IN - height
            box = (left_in[panel.letter] / page_width, low / page_height, _WIDTH_IN / page_width, height / page_height)
            panel.draw(figure.add_axes(box))
    return figure
