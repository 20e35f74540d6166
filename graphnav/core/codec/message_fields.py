"""Check that a message class has the fields of its LCM type."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from graphnav.core.codec.layout import PRIMITIVES, Field, fields_of, lcm_name
from graphnav.core.errors import DeclarationError
from graphnav.core.messages import Message

_OF_THE_RUNNER = ("utime", "seq")
_SCALARS: dict[str, tuple[type, ...]] = {"f": (float, int, bool), "d": (float, int, bool), "?": (bool,), "": (str,)}
"""The annotations of a scalar that `struct` packs, by its code; integers where there is no entry."""


def check_fields(message: type[Message]) -> None:
    """Raise DeclarationError if a message class does not have the fields of its LCM type.

    Names and kinds are compared: scalar or array, and whether the elements convert without loss. A class that converts
    its fields itself (``lcm_fields``, ``from_lcm_fields``) is not checked, nor is an annotation that is not understood.
    """
    if {"lcm_fields", "from_lcm_fields"} & {name for cls in _own_bases(message) for name in vars(cls)}:
        return
    wire = fields_of(message.lcm_class)
    sizes = {dim for field in wire for dim in field.dims}
    expected = {field.name: field for field in wire if field.name not in (*_OF_THE_RUNNER, *sizes)}
    declared = [field.name for field in fields(message)]
    who, type_name = f"message {message.__qualname__}", lcm_name(message.lcm_class)
    if set(declared) != set(expected):
        raise DeclarationError(
            f"{who} has the fields {_listed(declared)}, but its LCM type {type_name} has {_listed(expected)}"
        )
    wrong = [f"'{name}' is {what}" for name, what in _wrong_kinds(message, expected)]
    if wrong:
        raise DeclarationError(f"{who} does not hold what its LCM type {type_name} does: {', '.join(wrong)}")


def _own_bases(message: type[Message]) -> Iterator[type]:
    yield from (cls for cls in message.__mro__ if issubclass(cls, Message) and cls is not Message)


def _listed(names: Any) -> str:
    return ", ".join(names) or "none"


def _wrong_kinds(message: type[Message], expected: dict[str, Field]) -> Iterator[tuple[str, str]]:
    """Yield each field whose annotation cannot hold what the LCM type does, and both kinds."""
    try:
        hints = get_type_hints(message)
    except NameError:  # a type that only type checkers import
        return
    for name, field in expected.items():
        hint = hints[name]
        if not _fits(hint, field):
            dims = "".join(f"[{dim}]" for dim in field.dims)
            yield name, f"{_written(hint)} for {field.primitive}{dims}"


def _fits(hint: Any, field: Field) -> bool:
    """Whether an annotation is of the kind of a field; true where that is not clear."""
    dtype = array_dtype(hint)
    if field.struct is None and field.primitive != "string" and field.dims and dtype is not None:
        return np.can_cast(dtype, np.dtype(PRIMITIVES[field.primitive].replace("q", "i8")), "safe")
    if hint in (int, float, bool, str):
        allowed = _SCALARS.get(PRIMITIVES[field.primitive], (int, bool)) if field.struct is None else ()
        return not field.dims and hint in allowed
    return dtype is None or bool(field.dims)


def array_dtype(hint: Any) -> np.dtype[Any] | None:
    """Return the dtype of ``NDArray[...]``, None for anything else."""
    if get_origin(hint) is not np.ndarray:
        return None
    scalar = next((arg for dtype in get_args(hint)[1:] for arg in get_args(dtype)), None)
    return np.dtype(scalar) if isinstance(scalar, type) and issubclass(scalar, np.generic) else None


def _written(hint: Any) -> str:
    dtype = array_dtype(hint)
    return f"an array of {dtype}" if dtype is not None else getattr(hint, "__name__", str(hint))
