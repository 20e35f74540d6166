"""Check that the fields of a dataclass that was read from a file have the declared types."""

from __future__ import annotations

import dataclasses
import math
import types
from collections.abc import Mapping
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints


def check_types(instance: Any) -> None:
    """Check every field of a dataclass, and those of the dataclasses in it.

    Raises
    ------
    TypeError
        A field holds something that its annotation excludes; names it.
    """
    kinds = get_type_hints(type(instance))
    for field in dataclasses.fields(instance):
        if not _fits(kinds[field.name], getattr(instance, field.name)):
            raise TypeError(f"{type(instance).__name__}.{field.name} has another type")


def _fits(kind: Any, value: Any) -> bool:
    origin, args = get_origin(kind), get_args(kind)
    if origin in (Union, types.UnionType):
        return any(_fits(one, value) for one in args)
    if origin is Literal:
        return isinstance(value, str | int) and value in args
    if origin is tuple:
        return isinstance(value, tuple) and _fit(args, value)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        pairs = isinstance(value, Mapping) and value.items()
        return pairs is not False and all(_fits(args[0], key) and _fits(args[1], one) for key, one in pairs)
    if kind is float:
        return isinstance(value, int | float) and not isinstance(value, bool) and _is_finite(value)
    return kind is Any or (type(value) is kind and _are_fields_right(value))


def _are_fields_right(value: Any) -> bool:
    """Return True, once the fields of a dataclass are checked; other values have none."""
    if dataclasses.is_dataclass(value):
        check_types(value)
    return True


def _fit(kinds: tuple[Any, ...], values: tuple[Any, ...]) -> bool:
    if kinds[-1] is Ellipsis:
        return all(_fits(kinds[0], value) for value in values)
    return len(kinds) == len(values) and all(map(_fits, kinds, values))


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer beyond what a float holds
        return False
