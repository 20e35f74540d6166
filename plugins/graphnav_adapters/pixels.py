"""Pixels of pictures that are received and sent: their shape, the limit of their size, the padding of their rows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphnav import FieldError
from graphnav.arrays import Bytes

MAX_PIXELS = 64_000_000
"""More than any robot camera has; a larger declared size is refused before memory is allocated."""


class Names(NamedTuple):
    """Names of a type's fields, for errors."""

    data_size: str
    rows: str
    row_stride: str


def check_size(rows: int, cols: int, of: str = "") -> None:
    """Raise FieldError unless a picture has at least one pixel and at most `MAX_PIXELS`; ``of``: begins its fields."""
    for name, size in (("height", rows), ("width", cols)):
        if size < 1:
            raise FieldError(f"{of}{name}", size, "1 or more")
    if rows * cols > MAX_PIXELS:
        raise FieldError(f"{of}width * height", f"{cols} * {rows}", f"{MAX_PIXELS // 10**6} million at most")


def without_padding(data: Bytes, rows: int, row_bytes: int, row_stride: int, names: Names) -> Bytes:
    """Return (rows, row_bytes) of rows that begin every ``row_stride`` bytes; the last one may lack its padding.

    Raises
    ------
    ValueError
        The numbers contradict each other.
    """
    if row_stride < row_bytes:
        raise FieldError(names.row_stride, row_stride, f"{row_bytes} or more, the bytes of a row")
    min_size, max_size = row_stride * (rows - 1) + row_bytes, row_stride * rows
    if not min_size <= data.size <= max_size:
        product = f"{names.rows} * {names.row_stride} = {rows} * {row_stride} = {max_size}"
        raise FieldError(names.data_size, data.size, product)
    padded: Bytes = np.ndarray((rows, row_bytes), np.uint8, np.ascontiguousarray(data), strides=(row_stride, 1))
    return np.ascontiguousarray(padded)


def shape_of(pixels: Bytes) -> tuple[int, int, int]:
    """Return rows, columns and channels; raises ValueError for a picture that is neither gray nor red-green-blue."""
    if pixels.ndim == 2:
        return (*pixels.shape, 1)
    if pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ValueError(f"pixels of shape {pixels.shape} are neither (rows, cols) nor (rows, cols, 3)")
    return (*pixels.shape[:2], 3)
