"""LCM types compiled to codecs."""

from __future__ import annotations

import functools
import itertools
import struct
from collections.abc import Iterator, Mapping
from typing import Any

from graphnav.core.codec.errors import DecodeError, EncodeError
from graphnav.core.codec.field_codecs import ArrayPart, ElementArray, Nested, NumberArray, Part, Scalars, String, Values
from graphnav.core.codec.flat_decode import field_decoder, is_flat, measure
from graphnav.core.codec.flat_encode import field_encoder
from graphnav.core.codec.layout import PRIMITIVES, Field, fields_of, fingerprint, lcm_name

_FINGERPRINT_BYTES = 8
_INTEGERS = frozenset("bhiq")
Peek = tuple[struct.Struct, int]
"""The unpack function of a field, and the field's offset in the message."""


class Codec:
    """Encodes and decodes one LCM type.

    The bytes are those of lcm-gen's own encoder. Arrays of numbers are numpy arrays, native-endian and read-only when
    decoded; arrays of strings and of structs are tuples (arrays of objects if they have several axes); a struct is
    a dict.
    """

    def __init__(self, lcm_class: type, under_way: Mapping[type, Codec] | None = None) -> None:
        self.name = lcm_name(lcm_class)
        self.fingerprint = fingerprint(lcm_class)
        fields = fields_of(lcm_class)
        self.fields = tuple(field.name for field in fields)
        self._known = frozenset(self.fields)
        self._sizes = tuple({dim for field in fields for dim in field.dims if isinstance(dim, str)})
        self._flat_encode = field_encoder(fields, self.fingerprint) if is_flat(fields) else None
        self._flat_decode = field_decoder(fields, self.fingerprint) if is_flat(fields) else None
        has_strings = any(field.primitive == "string" for field in fields)
        self._flat_measure = measure(fields, self.fingerprint) if is_flat(fields) and not has_strings else None
        self._peeks = peeks(fields)
        self.min_bytes = 0
        self._parts: list[Part] = []
        self._arrays: list[ArrayPart] = []
        for part in self._compile(fields, {**(under_way or {}), lcm_class: self}):
            self._parts.append(part)
            self.min_bytes += part.min_bytes

    def encode(self, fields: Mapping[str, Any]) -> bytes:
        """Return the message. Fields that hold array sizes may be left out; where they are given, they must agree.

        Raises EncodeError, naming the field.
        """
        if self._flat_encode is not None and (data := self._flat_encode(fields)) is not None:
            return data
        out: list[Any] = [self.fingerprint]
        self.encode_into(fields, out)
        return b"".join(out)

    def decode(self, data: bytes) -> Values:
        """Return all fields of a message; raises DecodeError for anything that is not a message of this type."""
        if self._flat_decode is not None and (flat := self._flat_decode(data)) is not None:
            return flat
        if data[:8] != self.fingerprint:
            found = data[:8].hex() or "nothing"
            raise DecodeError(f"not of type {self.name}: it begins with {found}, expected {self.fingerprint.hex()}")
        try:
            values, end = self.decode_from(data, 8)
        except DecodeError as error:
            raise DecodeError(f"a damaged {self.name} of {len(data)} bytes: {error}") from error
        except RecursionError as error:
            raise DecodeError(f"a damaged {self.name} of {len(data)} bytes: nested too deep") from error
        if end != len(data):
            sizes = ", ".join(f"{name} = {values[name]}" for name in self.fields if name in self._sizes)
            ending = f"its fields end at byte {end}{' where ' * bool(sizes)}{sizes}"
            raise DecodeError(f"a damaged {self.name} of {len(data)} bytes: {ending}")
        return values

    def fits(self, data: bytes) -> bool:
        """Whether the bytes are a complete message of this type; arrays of numbers are measured and not made."""
        if self._flat_measure is not None:
            return bool(self._flat_measure(data))
        try:
            self.decode(data)
        except DecodeError:
            return False
        return True

    def peek(self, data: bytes, name: str) -> int | None:
        """Return one integer of a complete message, None if the type has no such field or it is not an integer.

        Cheap for leading scalars, such as timestamp and sequence number; otherwise all fields are decoded.
        """
        if name in self._peeks:
            packer, at = self._peeks[name]
            return int(packer.unpack_from(data, at)[0])
        value = self.decode(data).get(name) if name in self._known else None
        return value if isinstance(value, int) else None

    def encode_into(self, fields: Mapping[str, Any], out: list[Any]) -> None:
        """Append the bytes of a struct without its fingerprint."""
        self._check_names(fields)
        try:
            values = self._take_arrays(fields) if self._arrays else fields
            for part in self._parts:
                part.encode(values, out)
        except KeyError as error:
            raise EncodeError(f"{self.name}.{error.args[0]} is missing") from error
        except EncodeError as error:
            raise EncodeError(f"{self.name}.{error}") from error

    def decode_from(self, data: bytes, at: int) -> tuple[Values, int]:
        """Return the struct at an offset and the offset after it."""
        values: Values = {}
        for part in self._parts:
            at = part.decode(data, at, values)
        return values, at

    def _check_names(self, fields: Mapping[str, Any]) -> None:
        if type(fields) is not dict and not isinstance(fields, Mapping):
            raise EncodeError(f"{self.name}: expected a mapping, found {fields!r}")
        if not self._known.issuperset(fields):
            raise EncodeError(f"{self.name} has no field {', '.join(sorted(set(fields) - self._known))}")

    def _take_arrays(self, fields: Mapping[str, Any]) -> Values:
        """Return the fields with arrays prepared for encoding and all sizes filled in."""
        values = dict(fields)
        sizes = {name: values[name] for name in self._sizes if name in values}
        for array in self._arrays:
            try:
                shape, values[array.name] = array.take(values[array.name])
            except EncodeError as error:
                raise EncodeError(f"{array.name}: {error}") from error
            for dim, size in zip(array.dims, shape):  # noqa: B905, take returns as many sizes, and strict costs time
                if dim != size and size is not None and (isinstance(dim, int) or sizes.setdefault(dim, size) != size):
                    raise EncodeError(f"{array.name}: expected shape {_wanted(array, sizes)}, found {shape}")
        for name in self._sizes:
            values[name] = sizes.get(name, 0)
        return values

    def _compile(self, fields: list[Field], under_way: Mapping[type, Codec]) -> Iterator[Part]:
        """Yield the field codecs; a recursive type finds its own codec in ``under_way``."""
        for scalar, group in itertools.groupby(fields, _is_scalar):
            if scalar:
                yield Scalars(list(group))
                continue
            for field in group:
                codec = None
                if field.struct is not None:
                    codec = under_way.get(field.struct) or Codec(field.struct, under_way)
                if field.dims:
                    number = codec is None and field.primitive != "string"
                    array: ArrayPart = NumberArray(field) if number else ElementArray(field, codec)
                    self._arrays.append(array)
                    yield array
                else:
                    yield String(field.name) if codec is None else Nested(field.name, codec)


@functools.cache
def codec_of(lcm_class: type) -> Codec:
    """Return the codec of an lcm-gen class."""
    return Codec(lcm_class)


def _wanted(array: ArrayPart, sizes: Mapping[str, int]) -> str:
    """Return the expected shape of an array, as far as the other fields define it."""
    known: Mapping[Any, int] = sizes
    return f"({', '.join(f'{dim}={known[dim]}' if dim in known else str(dim) for dim in array.dims)})"


def peeks(fields: list[Field]) -> dict[str, Peek]:
    """Return a peek for each integer before the first string, array or struct."""
    found: dict[str, Peek] = {}
    at = _FINGERPRINT_BYTES
    for field in itertools.takewhile(_is_scalar, fields):
        packer = struct.Struct(">" + PRIMITIVES[field.primitive])
        if packer.format[-1] in _INTEGERS:
            found[field.name] = packer, at
        at += packer.size
    return found


def _is_scalar(field: Field) -> bool:
    return not field.dims and field.struct is None and field.primitive != "string"
