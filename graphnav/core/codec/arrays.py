"""Arrays of numbers: conversion between Python sequences, numpy arrays and the wire format."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from graphnav.core.codec.errors import DecodeError, EncodeError
from graphnav.core.codec.layout import PRIMITIVES

Array = npt.NDArray[Any]
Shape = tuple[int | None, ...]
"""The shape of an array; None for a size that is unknown because an earlier axis is empty."""


class Numbers:
    """A primitive type: its numpy dtype in memory and on the wire."""

    def __init__(self, primitive: str) -> None:
        self.native = np.dtype(PRIMITIVES[primitive].replace("q", "i8"))
        self.wire = self.native.newbyteorder(">")
        self._size = self.native.itemsize

    def take(self, value: Any, axes: int) -> tuple[Shape, Array]:
        """Return the shape and the array of ``value``; no copy of an array.

        An array's dtype must convert without loss. Numbers in lists have no width: each value is checked.
        Raises EncodeError.
        """
        array = value if type(value) is np.ndarray else self._from_sequence(value)
        if array.dtype != self.native and not np.can_cast(array.dtype, self.native, "safe"):
            raise EncodeError(f"expected {self.native}, found {array.dtype}")
        shape: Shape = array.shape
        if array.ndim < axes and not array.size and array is not value:
            shape += (None,) * (axes - array.ndim)
        if len(shape) != axes:
            raise EncodeError(f"expected {axes} {'axis' if axes == 1 else 'axes'}, found shape {array.shape}")
        return shape, array

    def put(self, array: Array) -> Array:
        """Return the array in wire format: contiguous, big-endian."""
        return array.astype(self.wire, "C", "unsafe", True, False)  # noqa: FBT003, by position is faster

    def read(self, data: bytes, at: int, shape: tuple[int, ...]) -> tuple[Array, int]:
        """Return the read-only array of ``shape`` at offset ``at`` of ``data``, which is long enough, and its end.

        Raises DecodeError for a shape that numpy cannot make.
        """
        count = math.prod(shape)
        end = at + count * self._size
        try:
            if not count:
                array: Array = np.empty(shape, self.native)
            elif self._size > 1:
                array = np.frombuffer(data, self.wire, count, at).astype(self.native)
            elif self.native.kind == "b":
                array = np.frombuffer(data, np.uint8, count, at) != 0
            else:
                return np.frombuffer(data, self.native, count, at).reshape(shape), end
        except ValueError as error:
            raise DecodeError(f"shape {shape}: {error}") from error
        array.setflags(write=False)
        return (array if len(shape) == 1 else array.reshape(shape)), end

    def _from_sequence(self, value: Any) -> Array:
        if isinstance(value, bytes | bytearray | memoryview):
            return np.frombuffer(value, np.uint8)
        if isinstance(value, str):
            raise EncodeError(f"expected {self.native}, found str")
        try:
            array = np.asarray(value)
        except ValueError as error:
            raise EncodeError(f"ragged: {error}") from error
        if not array.size:
            return array.astype(self.native) if array.dtype == np.float64 else array
        if self.native.kind in "iu" and array.dtype.kind in "iub":
            bounds = np.iinfo(self.native)
            if array.min() < bounds.min or array.max() > bounds.max:
                raise EncodeError(f"expected {self.native}, found {array.min()} to {array.max()}")
            return array.astype(self.native)
        if self.native.kind == "f" and array.dtype.kind in "fiub":
            try:
                with np.errstate(over="raise"):
                    return array.astype(self.native)
            except FloatingPointError as error:
                raise EncodeError(f"expected {self.native}, found {np.abs(array).max()}") from error
        return array


def flatten(value: Any, axes: int) -> tuple[Shape, list[Any]]:
    """Return the shape and the elements, row-major, of sequences nested ``axes`` deep.

    Raises ValueError if they are ragged and TypeError if they are nested less deep.
    """
    if isinstance(value, np.ndarray) and value.ndim == axes:
        return value.shape, value.ravel().tolist()
    shape: list[int | None] = []
    level = [value]
    for axis in range(axes):
        for part in level:
            if not isinstance(part, list | tuple | np.ndarray):
                raise TypeError(f"expected a sequence on axis {axis}, found {type(part).__name__}")
        lengths = {len(part) for part in level}
        if len(lengths) > 1:
            raise ValueError(f"ragged on axis {axis}: lengths {sorted(lengths)}")
        shape.append(lengths.pop() if lengths else None)
        level = [element for part in level for element in part]
    return tuple(shape), level


def nest(elements: Sequence[Any], shape: Sequence[int]) -> Any:
    """Return ``elements``, row-major, as a tuple if ``shape`` has one axis, else as a read-only array of objects."""
    if len(shape) == 1:
        return tuple(elements)
    array = np.empty(len(elements), object)
    array[:] = elements
    array.setflags(write=False)
    return array.reshape(shape)
