"""ROS 2 without ROS: types by their definitions, messages as bytes (CDR, OMG DDS-XTypes 7.4), topics, networks."""

from __future__ import annotations

import os
import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from graphnav.core.codec import DecodeError, EncodeError
from graphnav.core.errors import DeclarationError, UserError, shown_value

LOOPBACK = "lo"
MAX_DOMAIN = 232
"""The last domain whose ports are below 65536."""
DOMAIN = "ROS_DOMAIN_ID"
"""The environment variable that sets the domain of ROS programs."""
MAX_BYTES = 1 << 26
"""A larger message is not read: more than any camera's picture has."""
PRIMITIVES: Mapping[str, str] = {
    "bool": "?",
    "byte": "u1",
    "char": "u1",
    "float32": "f4",
    "float64": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
}
"""The numbers of ROS definitions, as numpy calls them without byte order."""
STRING = "string"
COMMON: Mapping[str, str] = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
}
"""Types that a definition may use without defining them."""
TOPIC_PATTERN = r"(/[A-Za-z_][A-Za-z0-9_]*)+"
"""A regular expression for the names of topics; `why_not_a_topic` refuses two underscores in a row too."""

_TOPIC = re.compile(TOPIC_PATTERN)
_TYPE = re.compile(r"[A-Za-z][A-Za-z0-9_]*/(?:msg/)?[A-Za-z][A-Za-z0-9_]*")
_FIELD = re.compile(
    r"(?P<type>[A-Za-z][\w/]*)(?P<bound><=\d+)?(?P<array>\[(?:<=)?\d*\])?\s+(?P<name>[A-Za-z]\w*)(?P<rest>.*)"
)
_NESTED = re.compile(r"^=+\s*\nMSG: (\S+)\s*\n", re.MULTILINE)
_LITTLE, _BIG = "<", ">"
_REPRESENTATIONS: Mapping[bytes, tuple[str, int]] = {
    b"\x00\x00": (_BIG, 8),
    b"\x00\x01": (_LITTLE, 8),
    b"\x00\x06": (_BIG, 4),
    b"\x00\x07": (_LITTLE, 4),
}
"""Byte order and largest alignment, by the representation identifier: CDR, and plain CDR 2."""
_HEADER = b"\x00\x01\x00\x00"
"""Of what is written: CDR, little-endian."""
STAMP_AT = len(_HEADER)
"""Offset of the stamp in a message that begins with a header: int32 seconds, uint32 nanoseconds, little-endian."""
_PADDING = 3
"""Maximum number of bytes after the last field: writers round the size up to a multiple of 4."""


@dataclass(frozen=True)
class Ros2Network:
    """Where ROS 2 programs are: the domain, and the network interface."""

    domain: int | None = None
    """None: that of ``ROS_DOMAIN_ID``, else 0."""
    interface: str = LOOPBACK

    def __str__(self) -> str:
        return f"domain {self.domain or 0} through {self.interface}"

    def resolved(self) -> Ros2Network:
        """Return the network with the domain that it is.

        Raises
        ------
        UserError
            ``ROS_DOMAIN_ID`` is not a domain.
        """
        word = (os.environ.get(DOMAIN) or "0") if self.domain is None else str(self.domain)
        if not word.isdecimal() or int(word) > MAX_DOMAIN:
            hint = f"unset {DOMAIN}, or write ros2: {{domain: 0}} in the graph"
            raise UserError.of(f"{DOMAIN} is {word!r}, expected a number from 0 to {MAX_DOMAIN}", hint)
        return Ros2Network(int(word), self.interface)


def why_not_a_topic(name: str) -> tuple[str, str] | None:
    """Return why ROS refuses a topic's name, and a hint; None if it is fine."""
    if _TOPIC.fullmatch(name) and "__" not in name:
        return None
    absolute = f"/{name}"
    hint = f"write {absolute}" if _TOPIC.fullmatch(absolute) else "write /name or /space/name: letters, digits and _"
    return f"'{name}' is not a ROS topic", hint


class RosField(NamedTuple):
    """A field of a ROS type.

    ``kind``: a name of `PRIMITIVES`, `STRING` or the type of nested fields. ``size``: of an array; 0 for a sequence,
    None for a single value.
    """

    name: str
    kind: str | RosType
    size: int | None


@dataclass(frozen=True)
class RosType:
    """A ROS 2 message type by its definition, which is also the codec of its messages.

    ``definition`` is the text of the type's ``.msg`` file. Types that it uses, apart from those of `COMMON`, follow as
    in bags and MCAP files: a line of ``=``, a line ``MSG: package/Type``, their text. Fields decode to numbers, `str`,
    numpy arrays (read-only), mappings of nested fields, and lists of these. ``wstring`` is not supported.

    Raises DeclarationError if the definition cannot be read.
    """

    name: str
    """``package/Type``"""
    definition: str
    fields: Sequence[RosField] = field(init=False, compare=False)

    fingerprint = b""
    """Its bytes begin with no mark of the type: DDS compares types before messages are sent."""

    def __post_init__(self) -> None:
        texts = {**COMMON, **_texts(self.name, self.definition)}
        object.__setattr__(self, "fields", _fields(ros_name(self.name), texts, ()))

    @cached_property
    def dds_name(self) -> str:
        """The name of the type in DDS."""
        package, _, kind = ros_name(self.name).partition("/")
        return f"{package}::msg::dds_::{kind}_"

    def decode(self, data: bytes) -> dict[str, Any]:
        """Return the fields of a message.

        Raises
        ------
        DecodeError
            The bytes are not a message of this type, or more than 64 MiB.
        """
        if len(data) > MAX_BYTES:
            raise DecodeError(f"{len(data)} bytes, expected at most {MAX_BYTES}")
        order, max_align = _REPRESENTATIONS.get(data[:2], ("", 0))
        if not order or len(data) < len(_HEADER):
            raise DecodeError(f"the bytes begin with {data[:4].hex(' ') or 'nothing'}, expected 00 01 00 00: CDR")
        reader = _Reader(memoryview(data)[len(_HEADER) :], order, max_align)
        try:
            fields = reader.struct(self)
        except struct.error as error:
            raise DecodeError(f"{len(data)} bytes end within a {self.name}") from error
        if (left := reader.left) > _PADDING:
            raise DecodeError(f"{left} of {len(data)} bytes are left after the last field of a {self.name}")
        return fields

    def encode(self, fields: Mapping[str, Any]) -> bytes:
        """Return the bytes of a message (CDR, little-endian); fields that are missing are zero or empty.

        Raises
        ------
        EncodeError
            A field is unknown, or its value does not fit.
        """
        writer = _Writer()
        writer.struct(self, fields, "")
        return _HEADER + bytes(writer.bytes)

    @property
    def is_stamped(self) -> bool:
        """Whether its messages begin with a `std_msgs/Header`, whose stamp stands at `STAMP_AT`."""
        first = next(iter(self.fields), None)
        return first is not None and isinstance(first.kind, RosType) and first.kind.name == "std_msgs/Header"


def ros_name(name: str) -> str:
    """Return ``package/Type`` of a name that may be written ``package/msg/Type``."""
    return name.replace("/msg/", "/")


def time_us(sec: int, nanosec: int) -> int:
    """Return the microseconds of a ``builtin_interfaces/Time``."""
    return int(sec) * 1_000_000 + int(nanosec) // 1000


def time_fields(utime: int) -> dict[str, int]:
    """Return the fields of a ``builtin_interfaces/Time`` of so many microseconds."""
    sec, us = divmod(utime, 1_000_000)
    return {"sec": sec, "nanosec": us * 1000}


def _texts(name: str, definition: str) -> dict[str, str]:
    """Return the definition of a type and those of the types that follow it, by name."""
    first, *others = _NESTED.split(definition)
    return {ros_name(name): first} | {
        ros_name(other): text for other, text in zip(others[::2], others[1::2], strict=True)
    }


def _fields(name: str, texts: Mapping[str, str], within: tuple[str, ...]) -> tuple[RosField, ...]:
    """Return the fields of a type; ``within``: the types that it is nested in."""
    if name in within:
        raise DeclarationError(f"the ROS type '{name}' contains itself")
    if not _TYPE.fullmatch(name):
        raise DeclarationError(f"'{name}' is not the name of a ROS type: write package/Type")
    if name not in texts:
        raise DeclarationError(
            f"the definition of '{(*within, name)[0]}' uses '{name}' without its definition: append '===', a line "
            f"'MSG: {name}' and its text"
        )
    found = []
    for line in texts[name].splitlines():
        words = line.partition("#")[0].strip()
        match = _FIELD.fullmatch(words)
        if not words or (match is not None and match["rest"].lstrip().startswith("=")):
            continue  # a constant is not sent
        if match is None:
            raise DeclarationError(f"the definition of '{name}' has the line '{line.strip()}', expected: type name")
        found.append(RosField(match["name"], _kind(match["type"], name, texts, within), _size(match["array"])))
    return tuple(found)


def _kind(word: str, name: str, texts: Mapping[str, str], within: tuple[str, ...]) -> str | RosType:
    if word in PRIMITIVES or word == STRING:
        return word
    if word == "wstring":
        raise DeclarationError(f"the definition of '{name}' has a wstring, which is not supported")
    full = "std_msgs/Header" if word == "Header" else ros_name(word)
    if "/" not in full:
        full = f"{name.partition('/')[0]}/{full}"
    _fields(full, texts, (*within, name))
    parts = [texts[full], *(f"===\nMSG: {other}\n{text}" for other, text in texts.items() if other not in COMMON)]
    return RosType(full, "\n".join(parts))


def _size(array: str | None) -> int | None:
    if array is None:
        return None
    digits = array.strip("[]")
    return int(digits) if digits.isdecimal() else 0


class _Reader:
    """Reads fields at a position that moves on; raises struct.error where the bytes end."""

    def __init__(self, data: memoryview, order: str, max_align: int) -> None:
        self._data, self._order, self._max_align = data, order, max_align
        self._at = 0

    @property
    def left(self) -> int:
        """Number of bytes that are not read."""
        return len(self._data) - self._at

    def struct(self, kind: RosType) -> dict[str, Any]:
        """Return the fields of a type."""
        return {one.name: self._field(one) for one in kind.fields}

    def _field(self, one: RosField) -> Any:
        if one.size is None:
            return self._value(one.kind)
        count = one.size or self._count()
        if isinstance(one.kind, str) and one.kind in PRIMITIVES:
            return self._numbers(PRIMITIVES[one.kind], count)
        if count > self.left:  # each has at least a byte
            raise struct.error
        return [self._value(one.kind) for _ in range(count)]

    def _value(self, kind: str | RosType) -> Any:
        if isinstance(kind, RosType):
            return self.struct(kind)
        if kind == STRING:
            return self._string()
        number = self._numbers(PRIMITIVES[kind], 1)
        return number[0].item()

    def _count(self) -> int:
        return int(self._numbers("u4", 1)[0])

    def _string(self) -> str:
        size = self._count()
        text = self._bytes(size)
        if not size or text[-1]:
            raise DecodeError("a string does not end with a zero byte")
        return bytes(text[:-1]).decode("utf-8", "replace")

    def _numbers(self, kind: str, count: int) -> np.ndarray[Any, Any]:
        if kind == "?":
            flags: np.ndarray[Any, Any] = np.frombuffer(self._bytes(count), np.uint8) != 0
            return flags
        dtype = np.dtype(self._order + kind)
        if count:
            self._at += -self._at % min(dtype.itemsize, self._max_align)
        found: np.ndarray[Any, Any] = np.frombuffer(self._bytes(count * dtype.itemsize), dtype)
        return found.astype(dtype.newbyteorder("="), copy=False)

    def _bytes(self, size: int) -> memoryview:
        if size > self.left:
            raise struct.error
        self._at += size
        return self._data[self._at - size : self._at]


class _Writer:
    """Appends fields, aligned from the first one."""

    def __init__(self) -> None:
        self.bytes = bytearray()

    def struct(self, kind: RosType, fields: Mapping[str, Any], where: str) -> None:
        """Append the fields of a type; ``where``: what its fields' names follow in errors."""
        if not isinstance(fields, Mapping):
            raise EncodeError(f"{where.rstrip('.')} is {shown_value(fields)}, expected the fields of {kind.name}")
        known = [one.name for one in kind.fields]
        if unknown := next((name for name in fields if name not in known), None):
            raise EncodeError(f"{kind.name} has no field '{unknown}': it has {', '.join(known)}")
        for one in kind.fields:
            self._field(one, fields.get(one.name), f"{where}{one.name}")

    def _field(self, one: RosField, value: Any, where: str) -> None:
        if one.size is None:
            self._value(one.kind, value, where)
            return
        values = () if value is None else value
        if one.size and value is not None and len(values) != one.size:
            raise EncodeError(f"{where} has {len(values)} elements, expected {one.size}")
        if not one.size:
            self._numbers("u4", len(values), where)
        if isinstance(one.kind, str) and one.kind in PRIMITIVES:
            self._numbers(PRIMITIVES[one.kind], np.zeros(one.size, np.uint8) if value is None else values, where)
            return
        for k, element in enumerate(values if value is not None else (None,) * one.size):
            self._value(one.kind, element, f"{where}[{k}]")

    def _value(self, kind: str | RosType, value: Any, where: str) -> None:
        if isinstance(kind, RosType):
            self.struct(kind, {} if value is None else value, f"{where}.")
        elif kind == STRING:
            text = str("" if value is None else value).encode() + b"\0"
            self._numbers("u4", len(text), where)
            self.bytes += text
        else:
            self._numbers(PRIMITIVES[kind], 0 if value is None else value, where)

    def _numbers(self, kind: str, value: Any, where: str) -> None:
        dtype = np.dtype(_LITTLE + kind)
        try:
            given = np.asarray(value)
        except (TypeError, ValueError) as error:
            raise _not_a(dtype, where, value) from error
        if given.dtype.kind not in ("buif" if dtype.kind == "f" else "bui") and given.size:
            raise _not_a(dtype, where, value)
        numbers = given.astype(dtype)
        if dtype.kind != "f" and not np.array_equal(numbers, given):
            raise _not_a(dtype, where, value)
        if numbers.size:
            self.bytes += bytes(-len(self.bytes) % dtype.itemsize)
            self.bytes += numbers.tobytes()


def _not_a(dtype: np.dtype[Any], where: str, value: Any) -> EncodeError:
    return EncodeError(f"{where} is {shown_value(value)}, expected {dtype.name}")


def nested_types(kind: RosType) -> Iterator[RosType]:
    """Yield the types of a type's fields, those of fields of fields first, then the type itself."""
    seen = set[str]()
    for one in kind.fields:
        if isinstance(one.kind, RosType):
            for inner in nested_types(one.kind):
                if inner.name not in seen:
                    seen.add(inner.name)
                    yield inner
    yield kind
