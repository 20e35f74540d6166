"""Nested sequences: arrays of strings and structs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

Shape = tuple[int | None, ...]
"""The shape of an array; None for a size that is unknown because an earlier axis is empty."""


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
