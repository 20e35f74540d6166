"""Codecs of the parts of an LCM type: each encodes and decodes some of its fields."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from operator import itemgetter
from typing import Any, Protocol

from graphnav.core.codec.arrays import Numbers, Shape, flatten, nest
from graphnav.core.codec.errors import DecodeError, EncodeError
from graphnav.core.codec.layout import PRIMITIVES, Dim, Field

Values = dict[str, Any]
_LENGTH = struct.Struct(">I")
_MAX_EMPTY_STRUCTS = 4096
"""The maximum number of structs without fields in an array: they take no bytes."""


class Part(Protocol):
    """Adjacent fields of a type."""

    min_bytes: int

    def encode(self, values: Mapping[str, Any], out: list[Any]) -> None:
        """Append the fields' bytes to ``out``."""

    def decode(self, data: bytes, at: int, values: Values) -> int:
        """Add the fields that begin at an offset to ``values`` and return the offset after them."""


class StructCodec(Protocol):
    """The codec of a nested struct."""

    min_bytes: int

    def encode_into(self, fields: Mapping[str, Any], out: list[Any]) -> None:
        """Append the struct's bytes to ``out``."""

    def decode_from(self, data: bytes, at: int) -> tuple[Values, int]:
        """Return the struct at an offset and the offset after it."""


class Scalars:
    """Consecutive fixed-size scalars, packed by one `struct.Struct`."""

    def __init__(self, fields: list[Field]) -> None:
        self._names = [field.name for field in fields]
        self._codes = [PRIMITIVES[field.primitive] for field in fields]
        self._struct = struct.Struct(">" + "".join(self._codes))
        self._get = itemgetter(*self._names) if len(fields) > 1 else lambda values: (values[self._names[0]],)
        self.min_bytes = self._struct.size

    def encode(self, values: Mapping[str, Any], out: list[Any]) -> None:
        """Append the scalars; EncodeError names the one that does not fit."""
        try:
            out.append(self._struct.pack(*self._get(values)))
        except (struct.error, OverflowError, TypeError) as error:
            for name, code in zip(self._names, self._codes, strict=True):
                try:
                    struct.pack(">" + code, values[name])
                except (struct.error, OverflowError, TypeError):
                    raise EncodeError(f"{name}: {error} (found {values[name]!r})") from error
            raise

    def decode(self, data: bytes, at: int, values: Values) -> int:
        """Read the scalars; DecodeError names the first one that is missing."""
        if at + self.min_bytes > len(data):
            ends = [at + struct.calcsize(">" + "".join(self._codes[: k + 1])) for k in range(len(self._codes))]
            name = next(name for name, end in zip(self._names, ends, strict=True) if end > len(data))
            raise DecodeError(f"it ends before the end of {name}")
        values.update(zip(self._names, self._struct.unpack_from(data, at)))  # noqa: B905, strict costs time
        return at + self.min_bytes


class String:
    """A string."""

    min_bytes = _LENGTH.size + 1

    def __init__(self, name: str) -> None:
        self._name = name

    def encode(self, values: Mapping[str, Any], out: list[Any]) -> None:
        """Append length, UTF-8 and a NUL."""
        _put_string(self._name, values[self._name], out)

    def decode(self, data: bytes, at: int, values: Values) -> int:
        """Read a string; invalid UTF-8 is replaced, as in lcm-gen."""
        values[self._name], at = _read_string(self._name, data, at)
        return at


class Nested:
    """A struct inside a struct."""

    def __init__(self, name: str, codec: StructCodec) -> None:
        self._name, self._codec = name, codec
        self.min_bytes = codec.min_bytes

    def encode(self, values: Mapping[str, Any], out: list[Any]) -> None:
        """Append the struct's fields."""
        self._codec.encode_into(values[self._name], out)

    def decode(self, data: bytes, at: int, values: Values) -> int:
        """Read the struct's fields."""
        values[self._name], at = self._codec.decode_from(data, at)
        return at


class ArrayPart(Part, Protocol):
    """An array: its shape determines the size fields."""

    name: str
    dims: tuple[Dim, ...]

    def take(self, value: Any) -> tuple[Shape, Any]:
        """Return the shape of a value and the prepared value for ``encode``."""


class NumberArray:
    """An array of numbers or booleans, converted by numpy."""

    def __init__(self, field: Field) -> None:
        self.name, self.dims = field.name, field.dims
        self._numbers = Numbers(field.primitive)
        self.min_bytes = _min_count(self.dims) * self._numbers.native.itemsize

    def take(self, value: Any) -> tuple[Shape, Any]:
        """Return the shape and the array; raises EncodeError if the value does not fit."""
        return self._numbers.take(value, len(self.dims))

    def encode(self, values: Mapping[str, Any], out: list[Any]) -> None:
        """Append the array that ``take`` returned."""
        out.append(self._numbers.put(values[self.name]))

    def decode(self, data: bytes, at: int, values: Values) -> int:
        """Read the array."""
        shape = _shape_of(self.dims, values)
        _require_bytes(self, shape, math.prod(shape) * self._numbers.native.itemsize, len(data) - at)
        values[self.name], at = self._numbers.read(data, at, shape)
        return at


class ElementArray:
    """An array of strings or structs."""

    def __init__(self, field: Field, codec: StructCodec | None) -> None:
        self.name, self.dims = field.name, field.dims
        self._codec = codec
        self.min_bytes = _min_count(self.dims) * (codec.min_bytes if codec else String.min_bytes)

    def take(self, value: Any) -> tuple[Shape, Any]:
        """Return the shape and the flat list of elements; raises EncodeError if the value does not fit."""
        try:
            return flatten(value, len(self.dims))
        except (TypeError, ValueError) as error:
            raise EncodeError(str(error)) from error

    def encode(self, values: Mapping[str, Any], out: list[Any]) -> None:
        """Append the elements that ``take`` returned."""
        for element in values[self.name]:
            if self._codec is None:
                _put_string(self.name, element, out)
            else:
                self._codec.encode_into(element, out)

    def decode(self, data: bytes, at: int, values: Values) -> int:
        """Read the elements; raises DecodeError before allocating more than the bytes can hold."""
        shape = _shape_of(self.dims, values)
        count = math.prod(shape)
        each = self._codec.min_bytes if self._codec else String.min_bytes
        if not each and count > _MAX_EMPTY_STRUCTS:
            raise DecodeError(
                f"{self.name} has {_shown(self.dims, shape)} elements, expected {_MAX_EMPTY_STRUCTS} at most"
            )
        _require_bytes(self, shape, count * each, len(data) - at)
        elements: list[Any] = []
        for _ in range(count):
            element, at = self._codec.decode_from(data, at) if self._codec else _read_string(self.name, data, at)
            elements.append(element)
        try:
            values[self.name] = nest(elements, shape)
        except ValueError as error:
            raise DecodeError(f"{self.name}: shape {shape}: {error}") from error
        return at


def _shape_of(dims: tuple[Dim, ...], values: Mapping[str, Any]) -> tuple[int, ...]:
    """Return the values of ``dims``, from a struct's fields; raises DecodeError for a negative one."""
    shape = tuple([dim if isinstance(dim, int) else values[dim] for dim in dims])
    if min(shape) < 0:
        dim, size = next((dim, size) for dim, size in zip(dims, shape, strict=True) if size < 0)
        raise DecodeError(f"{dim} is {size}, expected 0 or more")
    return shape


def _require_bytes(array: ArrayPart, shape: tuple[int, ...], needed: int, left: int) -> None:
    """Raise DecodeError if an array of this shape needs more bytes than are left."""
    if needed > left:
        sizes = _shown(array.dims, shape)
        raise DecodeError(f"{array.name} has {sizes} elements, which need {needed} bytes, but {left} are left")


def _shown(dims: tuple[Dim, ...], shape: tuple[int, ...]) -> str:
    """Return a shape with the fields that hold it: ``rows * cols * 2 = 120 * 160 * 2``."""
    names, sizes = (" * ".join(map(str, one)) for one in (dims, shape))
    return sizes if names == sizes else f"{names} = {sizes}"


def _min_count(dims: tuple[Dim, ...]) -> int:
    """Return the minimum number of elements of an array."""
    return math.prod(dim if isinstance(dim, int) else 0 for dim in dims)


def _put_string(name: str, value: Any, out: list[Any]) -> None:
    try:
        encoded = value.encode("utf-8")
    except (AttributeError, UnicodeEncodeError) as error:
        raise EncodeError(f"{name}: expected str, found {value!r}") from error
    out += (_LENGTH.pack(len(encoded) + 1), encoded, b"\0")


def _read_string(name: str, data: bytes, at: int) -> tuple[str, int]:
    if at + _LENGTH.size > len(data):
        raise DecodeError(f"it ends before the end of {name}")
    (length,) = _LENGTH.unpack_from(data, at)
    start, end = at + _LENGTH.size, at + _LENGTH.size + length
    if not length or end > len(data):
        expected = "1 or more, with the NUL" if not length else f"{len(data) - start} at most, which are left"
        raise DecodeError(f"the length of the string {name} is {length}, expected {expected}")
    return str(data[start : end - 1], "utf-8", "replace"), end


def read_strings(data: bytes, at: int, count: int) -> tuple[tuple[str, ...], int]:
    """Return adjacent strings and the offset after them; raises DecodeError if there are fewer."""
    if not 0 <= count <= (len(data) - at) // String.min_bytes:
        raise DecodeError(f"{count} strings in {len(data) - at} bytes")
    strings = []
    for _ in range(count):
        string, at = _read_string("", data, at)
        strings.append(string)
    return tuple(strings), at
