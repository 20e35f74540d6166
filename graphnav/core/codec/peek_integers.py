"""Offsets of a type's leading integers, which can be read without decoding the message."""

from __future__ import annotations

import itertools
import struct

from graphnav.core.codec.layout import PRIMITIVES, Field

_FINGERPRINT_BYTES = 8
_INTEGERS = frozenset("bhiq")

Peek = tuple[struct.Struct, int]
"""The unpack function of a field, and the field's offset in the message."""


def peeks(fields: list[Field]) -> dict[str, Peek]:
    """Return a peek for each integer before the first string, array or struct."""
    found: dict[str, Peek] = {}
    at = _FINGERPRINT_BYTES
    for field in itertools.takewhile(_has_fixed_size, fields):
        packer = struct.Struct(">" + PRIMITIVES[field.primitive])
        if packer.format[-1] in _INTEGERS:
            found[field.name] = packer, at
        at += packer.size
    return found


def _has_fixed_size(field: Field) -> bool:
    return not field.dims and field.struct is None and field.primitive != "string"
