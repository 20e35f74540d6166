"""Write values as YAML that reads back the same."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from graphnav.core.spec.value import parse_scalar

_PLAIN = re.compile(r"[A-Za-z0-9_./+][A-Za-z0-9_./+-]*(?: [A-Za-z0-9_./+-]+)*", re.ASCII)


def write_value(value: Any) -> str:
    """Return a value on one line: scalars plain where that is safe, lists and mappings in brackets."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{write_value(key)}: {write_value(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(write_value(item) for item in value) + "]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if value is None:
        return "null"
    if isinstance(value, float):
        return _number(value)
    if isinstance(value, str | Path):
        return _text(str(value))
    return str(value)


def _number(value: float) -> str:
    if math.isfinite(value):
        digits, e, exponent = repr(value).partition("e")
        return digits + ("" if "." in digits or not e else ".0") + e + exponent  # for YAML 1.1, 1e-09 is a string
    return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"


def _text(text: str) -> str:
    if _PLAIN.fullmatch(text) and parse_scalar(text) == text:
        return text
    return '"' + "".join(map(_escaped, text)) + '"'


def _escaped(char: str) -> str:
    if char in '"\\':
        return f"\\{char}"
    if char.isprintable():
        return char
    return f"\\u{ord(char):04x}" if ord(char) < 0x10000 else f"\\U{ord(char):08x}"
