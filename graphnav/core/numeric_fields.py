"""The numbers of a message as named arrays, and a message of such arrays: what networks read and give."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any, NamedTuple, TypeVar, get_type_hints

import numpy as np
import numpy.typing as npt

from graphnav.core.codec.layout import fields_of
from graphnav.core.codec.message_fields import array_dtype
from graphnav.core.messages import FieldError, Message

Array = npt.NDArray[Any]
M = TypeVar("M", bound=Message)
_EXACT = 2**53
"""Up to here a float64 holds every integer."""


class _Kind(NamedTuple):
    """Content of a numeric field: elements of ``dtype``, in an array or, where ``scalar`` is given, alone."""

    dtype: np.dtype[Any]
    scalar: type | None = None

    @property
    def given(self) -> np.dtype[Any]:
        """The type of the elements that `numeric_fields` gives."""
        return np.dtype(np.float32) if self.scalar is not None or self.dtype.kind == "f" else self.dtype


def numeric_fields(message: Message) -> dict[str, Array]:
    """Return the numbers of a message by the names of its fields, in the order of their declaration.

    An array has its own shape, a scalar is of shape (1,). Integers in arrays keep their type (uint8 for pixels and
    masks); floats, and every scalar, are float32, in which networks compute: a scalar is rounded to 24 bits. Strings
    and lists of strings are left out. An array of float32 or integers is the message's own: read-only if received.
    """
    message_class: type = type(message)
    return {
        name: np.array([value], np.float32) if kind.scalar else np.asarray(value, kind.given)
        for name, kind in _kinds(message_class).items()
        if (value := getattr(message, name)) is not None
    }


def message_from(message_class: type[M], arrays: Mapping[str, npt.ArrayLike], **others: Any) -> M:
    """Return the message of a class whose numeric fields are ``arrays``, as `numeric_fields` names and shapes them.

    ``others``: fields as the message holds them, such as strings; ``arrays`` come before them, and defaults of the
    class after. Elements become those of the field: for integers they are rounded and limited to the type's range (of
    64 bits to 2**53), for a boolean 0.5 or more is true. Whether floats are finite is checked where the message is
    published.

    Raises
    ------
    FieldError
        A field has no value, a scalar not one element, an array another type than numbers, or a NaN stands where
        integers are held; or a name is none of the class's fields.
    """
    cached: type = message_class
    kinds, values = _kinds(cached), dict(others)
    declared = {field.name: field for field in fields(message_class)}
    for name, given in arrays.items():
        if name not in kinds:
            raise FieldError(name, f"not a numeric field of {message_class.__name__}", ", ".join(kinds) or "none")
        values[name] = _value(name, kinds[name], given)
    for name, field in declared.items():
        if name not in values and field.default is MISSING and field.default_factory is MISSING:
            raise FieldError(name, "missing", f"a value for every field of {message_class.__name__}")
    return message_class(**values)


class NumericField(NamedTuple):
    """Elements and shape of the array that `numeric_fields` gives for a field."""

    dtype: np.dtype[Any]
    shape: tuple[int | None, ...] | None
    """None for an axis of any length; without a shape the field may have any."""


def numeric_layout(message_class: type[Message]) -> dict[str, NumericField]:
    """Return the fields of a message class that `numeric_fields` gives, as far as the class declares them."""
    cached: type = message_class
    dims = {field.name: field.dims for field in fields_of(message_class.lcm_class)}
    found: dict[str, NumericField] = {}
    for name, kind in _kinds(cached).items():
        axes = tuple(axis if isinstance(axis, int) else None for axis in dims.get(name, ()))
        found[name] = NumericField(kind.given, (1,) if kind.scalar is not None else axes or None)
    return found


@functools.cache
def _kinds(message_class: type[Message]) -> dict[str, _Kind]:
    hints = get_type_hints(message_class)
    kinds: dict[str, _Kind] = {}
    for field in fields(message_class):
        hint = hints[field.name]
        if hint in (int, float, bool):
            kinds[field.name] = _Kind(np.dtype(hint), hint)
        elif (dtype := array_dtype(hint)) is not None and dtype.kind in "biuf":
            kinds[field.name] = _Kind(dtype)
    return kinds


def _value(name: str, kind: _Kind, given: npt.ArrayLike) -> Any:
    array = np.asarray(given)
    if array.dtype.kind not in "biuf":
        raise FieldError(name, f"of {array.dtype}", "numbers")
    if kind.scalar is not None and array.size != 1:
        raise FieldError(name, f"of shape {array.shape}", "one number, of shape (1,)")
    dtype = kind.dtype
    if dtype.kind == "f":
        converted = array.astype(dtype)
    elif array.dtype.kind == "f" and np.isnan(array).any():
        raise FieldError(name, "NaN", "a number that can be rounded")
    elif dtype.kind == "b":
        converted = np.asarray(array >= 0.5)
    elif array.dtype == dtype:
        converted = array
    else:
        info = np.iinfo(dtype)
        converted = np.clip(np.rint(array), max(info.min, -_EXACT), min(info.max, _EXACT)).astype(dtype)
    return converted if kind.scalar is None else converted.item()
