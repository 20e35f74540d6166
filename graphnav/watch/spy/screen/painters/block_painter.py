"""Pictures by half blocks, which any terminal shows at low cost: two pixels per cell, or shades without colour."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np
from rich.color import Color
from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip

from graphnav.arrays import Bytes
from graphnav.watch.spy.screen.painters.painter import Cells, centred

UPPER_HALF = "▀"
_SHADES = np.array(list(" .:-=+*#%@"))
_BITS = 5
"""Bits per colour channel: a coarse quantisation merges adjacent cells to runs, and runs repeat."""
_COLOUR_BITS = 3 * _BITS
_CHANNEL_MASK, _COLOUR_MASK = (1 << _BITS) - 1, (1 << _COLOUR_BITS) - 1
Rgb = tuple[int, int, int]
_MAX_SEGMENTS = 50_000


class Run(NamedTuple):
    """Adjacent cells with the same upper and lower colours, 0 to 255 per channel."""

    length: int
    above: Rgb
    below: Rgb


def half_blocks(picture: Bytes) -> list[list[int]]:
    """Return the lines of a picture (rows, cols, 3), two of its rows per line; an odd last row is doubled.

    A line is a list of runs, each encoded as an integer for `run_of`, which makes them cheap to cache.
    """
    if len(picture) % 2:
        picture = np.concatenate([picture, picture[-1:]])
    quantised = (picture >> (8 - _BITS)).astype(np.int64)
    packed = quantised[..., 0] << 2 * _BITS | quantised[..., 1] << _BITS | quantised[..., 2]
    cells = packed[0::2] << _COLOUR_BITS | packed[1::2]
    starts = np.ones(cells.shape, bool)
    starts[:, 1:] = cells[:, 1:] != cells[:, :-1]
    places = np.flatnonzero(starts)
    lengths = np.diff(places, append=cells.size)
    runs = (lengths << 2 * _COLOUR_BITS | cells.reshape(-1)[places]).tolist()
    ends = np.cumsum(starts.sum(axis=1)).tolist()
    return [runs[begin:end] for begin, end in zip([0, *ends], ends, strict=False)]


def run_of(packed: int) -> Run:
    """Decode a run of `half_blocks`."""
    above, below = packed >> _COLOUR_BITS & _COLOUR_MASK, packed & _COLOUR_MASK
    return Run(packed >> 2 * _COLOUR_BITS, _rgb(above), _rgb(below))


def shades(picture: Bytes) -> list[str]:
    """Return the lines of a picture (rows, cols, 3) in characters from dark to bright, two of its rows per line."""
    if len(picture) % 2:
        picture = np.concatenate([picture, picture[-1:]])
    gray = picture.astype(np.float32) @ np.array([0.299, 0.587, 0.114], np.float32)
    level = (gray[0::2] + gray[1::2]) / 2 * (len(_SHADES) / 256)
    return ["".join(line) for line in _SHADES[level.astype(np.intp)]]


def _rgb(colour: int) -> Rgb:
    """Unpack a colour, scaled so that the brightest is white."""
    red, green, blue = (colour >> shift & _CHANNEL_MASK for shift in (2 * _BITS, _BITS, 0))
    return _widened(red), _widened(green), _widened(blue)


def _widened(channel: int) -> int:
    return channel << (8 - _BITS) | channel >> (2 * _BITS - 8)


class BlockPainter:
    """Two pixels per cell; characters from dark to bright without colour."""

    is_raw = False

    def __init__(self) -> None:
        self._segments: dict[int, Segment] = {}
        self._has_colour = not os.environ.get("NO_COLOR")

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the number of pixels of a view."""
        return max(1, 2 * rows), max(1, cols)

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines up to the last line of the picture."""
        if self._has_colour:
            kept = self._segments
            lines = [[kept.get(run) or self._segment(run) for run in line] for line in half_blocks(picture)]
        else:
            lines = [[Segment(line)] for line in shades(picture)]
        cells = self.place(picture, rows, cols)
        margin = [Segment(" " * cells.col)] if cells.col else []
        blank = [Strip([])] * cells.row
        return [*blank, *(Strip([*margin, *line], cells.col + cells.cols) for line in lines)]

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells of the picture."""
        return centred((picture.shape[0] + 1) // 2, picture.shape[1], rows, cols)

    def erase(self) -> str:
        """Return an empty sequence: writing over a picture replaces it."""
        return ""

    def _segment(self, packed: int) -> Segment:
        """Make the segment of a run; cached, because the next picture has similar runs."""
        if len(self._segments) >= _MAX_SEGMENTS:
            self._segments.clear()
        run = run_of(packed)
        style = Style(color=Color.from_rgb(*run.above), bgcolor=Color.from_rgb(*run.below))
        segment = self._segments[packed] = Segment(UPPER_HALF * run.length, style)
        return segment
