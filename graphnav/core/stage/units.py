"""Units of numbers, by the suffix of their names."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit as tables show it, and in words."""

    symbol: str
    words: str


UNITS: Mapping[str, Unit] = MappingProxyType(
    {
        "px": Unit("px", "pixels"),
        "m": Unit("m", "metres"),
        "m2": Unit("m²", "square metres"),
        "s": Unit("s", "seconds"),
        "ms": Unit("ms", "milliseconds"),
        "us": Unit("µs", "microseconds"),
        "hz": Unit("Hz", "hertz"),
        "rad": Unit("rad", "radians"),
        "deg": Unit("°", "degrees"),
        "degps": Unit("°/s", "degrees per second"),
        "mps": Unit("m/s", "metres per second"),
        "mps2": Unit("m/s²", "metres per second squared"),
        "mps3": Unit("m/s³", "metres per second cubed"),
        "radps": Unit("rad/s", "radians per second"),
        "radps2": Unit("rad/s²", "radians per second squared"),
        "ratio": Unit("ratio", "a ratio"),
        "gray": Unit("gray", "gray levels, 0 to 255"),
        "gray2": Unit("gray²", "squared gray levels per pixel"),
        "mb": Unit("MB", "megabytes"),
    }
)
_NONE = Unit("", "")


def unit_of(name: str) -> Unit:
    """Return the unit that the suffix of a name tells; symbol and words are empty without one."""
    stem, _, suffix = name.rpartition("_")
    return UNITS.get(suffix, _NONE) if stem else _NONE
