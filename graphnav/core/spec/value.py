"""The values of a YAML file, each with its place."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any

from graphnav.core.errors import Place

_NULL = ("", "~", "null", "Null", "NULL")
_TRUE = ("true", "True", "TRUE")
_FALSE = ("false", "False", "FALSE")
_INT = re.compile(r"[-+]?[0-9]{1,300}|0o[0-7]{1,300}|0x[0-9a-fA-F]{1,300}", re.ASCII)
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", re.ASCII)
_INFINITY = re.compile(r"([-+]?)\.(inf|Inf|INF)")
_NAN = (".nan", ".NaN", ".NAN")
_BASES = {"0o": 8, "0x": 16}
Scalar = bool | int | float | str | None


@dataclass(frozen=True)
class Value:
    """A scalar, a list of values, or a mapping of strings to entries."""

    data: Scalar | list[Value] | dict[str, Entry]
    place: Place

    def plain(self) -> Any:
        """Return the value without places."""
        if isinstance(self.data, list):
            return [item.plain() for item in self.data]
        if isinstance(self.data, dict):
            return {key: entry.value.plain() for key, entry in self.data.items()}
        return self.data

    @property
    def kind(self) -> str:
        """Description of the value for error messages: ``a list``, ``the number 3``."""
        match self.data:
            case dict():
                return "a mapping"
            case list():
                return "a list"
            case None:
                return "empty"
            case bool():
                return "true" if self.data else "false"
            case str():
                return (
                    f"the string '{self.data}'" if len(self.data) <= 60 else f"a string of {len(self.data)} characters"
                )
            case _:
                return f"the number {self.data}"


@dataclass(frozen=True)
class Entry:
    """The value of a key, and the place of the key."""

    place: Place
    value: Value
    is_override: bool = False
    """Whether an override gives it, not the graph's own file."""


def parse_scalar(text: str) -> Scalar:
    """Return what an unquoted scalar means; numbers beyond what a float holds are infinite."""
    if text in _NULL:
        return None
    if text in _TRUE or text in _FALSE:
        return text in _TRUE
    if _INT.fullmatch(text):
        return int(text, _BASES.get(text[:2], 10))
    if _FLOAT.fullmatch(text):
        return float(text)
    if infinity := _INFINITY.fullmatch(text):
        return -math.inf if infinity[1] == "-" else math.inf
    return math.nan if text in _NAN else text
