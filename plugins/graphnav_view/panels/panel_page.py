"""A page of equally large panels, each with a title above and a caption below."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from graphnav_view import style

_COLUMNS = 4
_WIDTH_IN, _GAP_IN, _SIDE_IN = 3.1, 0.4, 0.3
_HEAD_IN, _TITLE_IN, _CAPTION_IN, _FOOT_IN = 0.66, 0.3, 0.48, 0.06
_MIN_RATIO, _MAX_RATIO = 0.4, 1.2
_LETTERS_PER_IN = 13


@dataclass(frozen=True)
class Panel:
    """One picture of the page: its title, and what draws it into axes and returns the caption."""

    title: str
    draw: Callable[[Axes], str]
    letter: str = ""
    """Of the paper's panel that it shows, before the title."""


def draw_page(panels: Sequence[Panel], height_ratio: float, headline: str, about: str) -> Figure:
    """Return a figure with the panels, four in a row, ``height_ratio`` times as high as wide."""
    height = _WIDTH_IN * min(max(height_ratio, _MIN_RATIO), _MAX_RATIO)
    cell = _TITLE_IN + height + _CAPTION_IN
    columns = min(_COLUMNS, len(panels))
    page_width = 2 * _SIDE_IN + columns * (_WIDTH_IN + _GAP_IN) - _GAP_IN
    page_height = _HEAD_IN + -(-len(panels) // columns) * cell + _FOOT_IN
    figure = style.new_figure(page_width, page_height)

    def write(left_in: float, top_in: float, text: str, size: float, colour: str, weight: str) -> None:
        at = left_in / page_width, 1 - top_in / page_height
        figure.text(*at, text, va="top", fontsize=size, color=colour, fontweight=weight, linespacing=1.25)

    write(_SIDE_IN, 0.12, headline, 12.0, "black", "bold")
    shortened = textwrap.shorten(about, int(page_width * _LETTERS_PER_IN), placeholder=" …")
    write(_SIDE_IN, 0.37, shortened, 9.5, style.QUIET, "normal")
    for place, panel in enumerate(panels):
        line, column = divmod(place, columns)
        left, low = _SIDE_IN + column * (_WIDTH_IN + _GAP_IN), _HEAD_IN + line * cell + _TITLE_IN + height
        axes = figure.add_axes((left / page_width, 1 - low / page_height, _WIDTH_IN / page_width, height / page_height))
        axes.set_title(f"({panel.letter}) {panel.title}" if panel.letter else panel.title, loc="left", pad=5)
        write(left, low + 0.06, panel.draw(axes), 8.6, style.QUIET, "normal")
    return figure
