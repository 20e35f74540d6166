"""Rows of pixels that begin every so many bytes, as cameras send them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from graphnav import FieldError
from graphnav.arrays import Bytes


class Names(NamedTuple):
    """Names of a type's fields, for errors."""

    data_size: str
    rows: str
    row_stride: str


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
