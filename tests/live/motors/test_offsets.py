"""Offsets of stamp and sequence number, against bytes that lcm-gen makes."""

from __future__ import annotations

import struct
from typing import Any

import graphnav_lcm
import pytest

from graphnav.live.motors.offsets import offsets_of


def type_of(*fields: tuple[str, str]) -> type[Any]:
    """Return what lcm-gen would say of a type's layout; array fields end with ``[]``."""
    slots = [name.removesuffix("[]") for name, _ in fields]
    dims = [[2] if name.endswith("[]") else None for name, _ in fields]
    layout = {"__slots__": slots, "__typenames__": [kind for _, kind in fields], "__dimensions__": dims}
    return type("made_t", (), layout)


@pytest.mark.parametrize("lcm_class", [graphnav_lcm.twist_t, graphnav_lcm.image_t, graphnav_lcm.odometry_t])
def test_our_own_types_have_both(lcm_class: Any) -> None:
    stamp_at, seq_at = offsets_of(lcm_class)
    message = lcm_class()
    message.utime, message.seq = 1_234_567_890_123, 45
    data = message.encode()
    assert stamp_at is not None
    assert seq_at is not None
    assert struct.unpack_from(">q", data, stamp_at) == (1_234_567_890_123,)
    assert struct.unpack_from(">q", data, seq_at) == (45,)


@pytest.mark.parametrize(
    ("fields", "offsets"),
    [
        ([("timestamp", "int64_t"), ("speed", "double")], (8, None)),
        ([("utime", "int64_t")], (8, None)),
        ([("utime", "int64_t"), ("seq", "int32_t")], (8, None)),
        ([("utime", "int64_t"), ("seq[]", "int64_t")], (8, None)),
        ([("utime", "double")], (None, None)),
        ([("utime[]", "int64_t")], (None, None)),
        ([("speed", "double"), ("utime", "int64_t")], (None, None)),
        ([("time_s", "int64_t")], (None, None)),
    ],
)
def test_foreign_types_have_what_is_known_of_them(
    fields: list[tuple[str, str]], offsets: tuple[int | None, int | None]
) -> None:
    assert offsets_of(type_of(*fields)) == offsets
