"""Values computed once from received arrays, for every stage of a process that gets them."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar

import numpy.typing as npt

T = TypeVar("T")
Array = npt.NDArray[Any]


class Derived(Generic[T]):
    """Values by the arrays from which they are computed, kept as long as these.

    Stages that receive the same message get twins of it, which share their arrays: what the first one computes, the
    others find. The arrays must not change meanwhile; received ones are read-only.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[int, ...], tuple[tuple[weakref.ref[Array], ...], dict[Hashable, T]]] = {}

    def of(self, arrays: tuple[Array, ...], key: Hashable, compute: Callable[[], T]) -> T:
        """Return what was computed from these arrays under this key, else compute it."""
        places = tuple(map(id, arrays))
        held = self._found.get(places)
        if held is None or any(ref() is not array for ref, array in zip(held[0], arrays, strict=True)):
            refs = tuple(weakref.ref(array, lambda _: self._found.pop(places, None)) for array in arrays)
            held = self._found[places] = (refs, {})
        if key not in held[1]:
            held[1][key] = compute()
        return held[1][key]
