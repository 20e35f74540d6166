"""Pictures by sixels."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from PIL import Image
from textual.strip import Strip

from graphnav.arrays import Bytes, Doubles, Longs
from graphnav.watch.spy.screen.painters.painter import Cells, centred, raw_strips

SCALES = (1, 2, 3, 6)
"""Allowed terminal dots per pixel, down and right: divisors of the six rows of a band."""
MAX_COLOURS = 256
_BAND = 6
_FIRST = 63
"""The character of a column without a dot; a dot in row k of the band adds 2**k."""
_MAX_DOTS = 4096
_MAX_GRAYS = 64
"""More gray levels would not be visible, and take longer to send."""
_MAX_PX = 100_000
"""A larger picture would need more than a tenth of a core at 5 Hz: its pixels then cover several dots each."""
_XTERM_DOTS = 1000
"""By default xterm does not draw beyond this number of rows or columns of dots."""


def sixels(picture: Bytes, scale: int = 1, n_colours: int = MAX_COLOURS) -> str:
    """Return the escape sequence that draws a picture (rows, cols, 3) with its upper left corner at the cursor.

    ``scale``: terminal dots per pixel, one of `SCALES`; ``n_colours``: the number of colour registers of the terminal.
    Every dot of the picture is drawn, so previous content needs no erasing.
    """
    rows, cols = picture.shape[:2]
    if scale not in SCALES or not 0 < cols * scale <= _MAX_DOTS:
        raise ValueError(f"{cols} columns at {scale} dots a pixel")
    indices, palette = _reduced(picture, n_colours)
    registers = "".join(
        "#{};2;{};{};{}".format(place, *np.rint(palette[place] / 2.55).astype(int).tolist())
        for place in np.unique(indices)
    )
    return f'\x1bP0;1;0q"1;1;{cols * scale};{rows * scale}{registers}{_bands(indices, scale, len(palette))}\x1b\\'


def _reduced(picture: Bytes, n_colours: int) -> tuple[Longs, Doubles]:
    """Return the colour index of each pixel (rows, cols), and the colours (n, 3), 0 to 255.

    Gray pictures use the maximum number of levels: the octree, which is fast, has only 16 gray levels.
    """
    gray = picture[..., 0]
    if np.array_equal(gray, picture[..., 1]) and np.array_equal(gray, picture[..., 2]):
        levels = np.linspace(0, 255, min(n_colours, _MAX_GRAYS))
        nearest = np.rint(np.arange(256) * (len(levels) - 1) / 255).astype(np.int64)
        return nearest[gray], np.repeat(levels[:, None], 3, axis=1)
    max_levels = min(n_colours, MAX_COLOURS)
    reduced = Image.fromarray(picture).quantize(max_levels, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    return np.asarray(reduced).astype(np.int64), np.array(reduced.getpalette(), np.float64).reshape(-1, 3)


def _bands(indices: Longs, scale: int, n_colours: int) -> str:
    """Return the picture's bands: one line per colour of a band, all lines at the same position."""
    dots = _dots(indices, scale, n_colours)
    band_of_line, colour_of_line = np.nonzero(dots.any(axis=2))
    lines = dots[band_of_line, colour_of_line]
    starts = np.ones(lines.shape, bool)
    starts[:, 1:] = lines[:, 1:] != lines[:, :-1]
    line_of_run, col_of_run = np.nonzero(starts)
    ends = np.append(col_of_run[1:], lines.shape[1])
    ends[ends == 0] = lines.shape[1]
    value = lines[line_of_run, col_of_run].astype(np.int64)
    is_drawn = (value > 0) | (ends < lines.shape[1])
    runs = ((ends - col_of_run) * scale << _BAND | value)[is_drawn]
    run_counts = np.bincount(line_of_run[is_drawn], minlength=len(lines))
    text = list(map(_run_text, runs.tolist()))
    out: list[str] = []
    begin, band = 0, 0
    for line_band, colour, end in zip(
        band_of_line.tolist(), colour_of_line.tolist(), np.cumsum(run_counts).tolist(), strict=True
    ):
        out.append("-" * (line_band - band) if line_band > band else "$" if begin else "")
        out.append(f"#{colour}")
        out += text[begin:end]
        begin, band = end, line_band
    return "".join(out)


def _dots(indices: Longs, scale: int, n_colours: int) -> Bytes:
    """Return the dots (bands, colours, cols) of each colour in each band, one bit per row."""
    rows, cols = indices.shape
    rows_a_band = _BAND // scale
    n_bands = -(-rows // rows_a_band)
    dots = np.zeros((n_bands, n_colours, cols), np.uint8)
    columns = np.arange(cols)
    for row in range(rows_a_band):
        of_row = indices[row::rows_a_band]
        dots[np.arange(len(of_row))[:, None], of_row, columns] |= ((1 << scale) - 1) << scale * row
    return dots


@cache
def _run_text(run: int) -> str:
    """Return the characters of a run: its length times 64, and its dots."""
    length, letter = run >> _BAND, chr(_FIRST + (run & 63))
    return letter * length if length < 4 else f"!{length}{letter}"


class SixelPainter:
    """``cell_px`` returns the dots of a cell, which may change while the terminal is open."""

    is_raw = True

    def __init__(self, cell_px: Callable[[], tuple[int, int]], n_colours: int) -> None:
        self._cell_px = cell_px
        self._n_colours = n_colours

    def box_px(self, rows: int, cols: int) -> tuple[int, int]:
        """Return the maximum size that is drawn in time, in pixels of one or several dots."""
        scale, n_rows, n_cols = self._box(rows, cols)
        return max(1, n_rows // scale), max(1, n_cols // scale)

    def paint(self, picture: Bytes, rows: int, cols: int) -> list[Strip]:
        """Return the lines of the view; partially covered cells at the edge are blanked."""
        cells = self.place(picture, rows, cols)
        scale, (cell_rows, cell_cols) = self._box(rows, cols)[0], self._cell_px()
        covered = cells._replace(rows=picture.shape[0] * scale // cell_rows, cols=picture.shape[1] * scale // cell_cols)
        return raw_strips(rows, cols, cells, covered, sixels(picture, scale, self._n_colours))

    def place(self, picture: Bytes, rows: int, cols: int) -> Cells:
        """Return the cells that the picture covers at least partially."""
        scale, (cell_rows, cell_cols) = self._box(rows, cols)[0], self._cell_px()
        return centred(-(-picture.shape[0] * scale // cell_rows), -(-picture.shape[1] * scale // cell_cols), rows, cols)

    def erase(self) -> str:
        """Return an empty sequence: writing over a picture replaces it."""
        return ""

    def _box(self, rows: int, cols: int) -> tuple[int, int, int]:
        """Return the dots per pixel, and the rows and columns of dots of a view."""
        cell_rows, cell_cols = self._cell_px()
        n_rows, n_cols = min(rows * cell_rows, _XTERM_DOTS), min(cols * cell_cols, _XTERM_DOTS)
        fitting = (scale for scale in SCALES if (n_rows // scale) * (n_cols // scale) <= _MAX_PX)
        return next(fitting, SCALES[-1]), n_rows, n_cols
