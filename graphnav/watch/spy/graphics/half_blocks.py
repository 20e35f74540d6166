"""Pictures as characters: two pixels per cell, or shades without colour."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphnav.arrays import Bytes

UPPER_HALF = "▀"
_SHADES = np.array(list(" .:-=+*#%@"))
_BITS = 5
"""Bits per colour channel: a coarse quantisation merges adjacent cells to runs, and runs repeat."""
_COLOUR_BITS = 3 * _BITS
_CHANNEL_MASK, _COLOUR_MASK = (1 << _BITS) - 1, (1 << _COLOUR_BITS) - 1

Rgb = tuple[int, int, int]


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
