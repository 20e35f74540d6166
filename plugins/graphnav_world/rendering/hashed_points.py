"""Random points on unbounded planes, dense enough for any view: made from hashes, tile by tile, and never kept.

Layer k of a plane is a Poisson process on square tiles of which each is four tiles of layer k - 1. A point has a
rank, the density (1/m**2) from which on it exists: those of ranks below any density are a Poisson process of this
density, and a higher density only adds points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphnav.arrays import Doubles, Indices

POINTS = 4.0
"""Mean number of points of a tile."""
MAX_POINTS = 16
LAYERS = 4
"""Layers that are looked at; those above hold 1/256 of the points."""
_SIDE_0_M = (POINTS / 0.75) ** 0.5
"""Side of the tiles of layer 0, whose points have ranks from 1/4 to 1 per square metre."""
_BITS, _LAYER_0, _CENTER = 20, 32, 1 << 19
_MASK = (1 << _BITS) - 1
_UNIT = 2.0**-21

_GOLDEN, _LOW = np.uint64(0x9E3779B97F4A7C15), np.uint64((1 << 21) - 1)
_CUMULATIVE = np.cumsum([math.exp(-POINTS) * POINTS**k / math.factorial(k) for k in range(MAX_POINTS)])
"""Poisson's distribution of the number of points of a tile."""

Keys = NDArray[np.int64]
"""Tiles: plane, layer, and column and row of the tile in one integer each."""


class Points(NamedTuple):
    """Points on planes: the plane's index, coordinates on it (2, points), metres, the rank, and a sign."""

    plane: Indices
    place_m: Doubles
    rank: Doubles
    sign: Doubles


def tiles_at(plane: Indices, place_m: Doubles, density: Doubles) -> Keys:
    """Return the tiles of the finest layer that is needed at places (2, n) for densities (1/m**2), each once."""
    layer = np.floor(-np.log2(density) / 2).astype(np.int64)
    column, row = np.floor(place_m / (_SIDE_0_M * 2.0**layer)).astype(np.int64) + _CENTER
    return _unique((((plane.astype(np.int64) << 6 | layer + _LAYER_0) << _BITS | column) << _BITS) | row)


def parents(tiles: Keys) -> Keys:
    """Return the tiles of the next layer that contain these, each once."""
    column, row = ((part - _CENTER >> 1) + _CENTER for part in (tiles >> _BITS & _MASK, tiles & _MASK))
    return _unique(((tiles >> 2 * _BITS) + 1 << 2 * _BITS) | column << _BITS | row)


def points_of(tiles: Keys, salt: int) -> Points:
    """Return the points of tiles; ``salt``: another set of points, independent of all others."""
    seed = _hashed(tiles.view(np.uint64) ^ np.uint64(salt))
    count = np.searchsorted(_CUMULATIVE, (seed >> np.uint64(11)) * 2.0**-53, side="right")
    tile = np.repeat(np.arange(len(tiles)), count)
    number = np.arange(len(tile)) - np.repeat(np.cumsum(count) - count, count) + 1
    bits = _hashed(seed.take(tile) + number.astype(np.uint64) * _GOLDEN)
    key = tiles.take(tile)
    layer = (key >> 2 * _BITS & 63) - _LAYER_0
    corner = np.stack([key >> _BITS & _MASK, key & _MASK]) - _CENTER
    within = np.stack([bits & _LOW, bits >> np.uint64(21) & _LOW]) * _UNIT
    share = 0.25 + 0.75 * (bits >> np.uint64(42) & _LOW) * _UNIT
    return Points(
        plane=(key >> 2 * _BITS + 6).astype(np.intp),
        place_m=(corner + within) * (_SIDE_0_M * 2.0**layer),
        rank=share * 4.0**-layer,
        sign=np.where(bits >> np.uint64(63), 1.0, -1.0),
    )


def _unique(keys: Keys) -> Keys:
    ordered = np.sort(keys)
    is_new = np.ones(len(ordered), np.bool_)
    np.not_equal(ordered[1:], ordered[:-1], out=is_new[1:])
    return ordered[is_new]


def _hashed(words: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Return well mixed bits: splitmix64 (G. L. Steele et al., Fast splittable pseudorandom generators, 2014)."""
    words = words + _GOLDEN
    words = (words ^ words >> np.uint64(30)) * np.uint64(0xBF58476D1CE4E5B9)
    words = (words ^ words >> np.uint64(27)) * np.uint64(0x94D049BB133111EB)
    return words ^ words >> np.uint64(31)
