"""Identify the types of messages by their fingerprints, without decoding."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from graphnav.core.codec import codec_of, fields_of, lcm_name, type_of

_STAMP = struct.Struct(">qq")
_FINGERPRINT_BYTES = 8


@dataclass(frozen=True)
class Kind:
    """A known type: ``min_bytes`` of a message; ``is_stamped``: whether it begins with ``utime`` and ``seq``."""

    lcm_class: type
    name: str
    min_bytes: int
    is_stamped: bool

    def stamp(self, data: bytes) -> tuple[int, int] | None:
        """Return the timestamp (microseconds) and sequence number of a message, None for a type without them."""
        return _STAMP.unpack_from(data, _FINGERPRINT_BYTES) if self.is_stamped else None


class Kinds:
    """Finds the type of a message, with a cache."""

    def __init__(self) -> None:
        self._known: dict[bytes, Kind] = {}

    def of(self, data: bytes) -> Kind | None:
        """Return the type of a message by its fingerprint, None if it is not installed."""
        prefix = data[:_FINGERPRINT_BYTES]
        kind = self._known.get(prefix)
        if kind is None and (lcm_class := type_of(data)) is not None:
            self._known[prefix] = kind = _kind(lcm_class)
        return kind


def _kind(lcm_class: type) -> Kind:
    first = [(field.name, field.primitive, field.dims) for field in fields_of(lcm_class)[:2]]
    is_stamped = first == [("utime", "int64_t", ()), ("seq", "int64_t", ())]
    return Kind(
        lcm_class, lcm_name(lcm_class), _FINGERPRINT_BYTES + codec_of(lcm_class).min_bytes, is_stamped=is_stamped
    )
