"""Seeded mutations of YAML, JSON, tables and binary files."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any

import yaml  # noqa: TID251 - files are spoiled, not read

_NUMBERS = (0, -1, 1, 3, 1e-300, -1e308, 1e308, 3e8, 10**40, float("nan"), float("inf"), float("-inf"), True)
_STRINGS = (
    "",
    " ",
    "x" * 5000,
    "\x1b]0;owned\x07",
    "\x1b[2J\x1b[31mred",
    "[red]bold[/]",
    "a\u202eb\u2066c\u200f",
    "\x00\x85\u2028",
    "null",
    "~nouser/file",
    "/dev/zero",
    "/dev/stdin",
    "../" * 200,
    "robot.image",
    "plane.ica",
    "$HOME",
    "%s%n",
    "\ud800",
)
_TOKENS = (
    "&a ",
    "*a ",
    "!!python/object/apply:os.system ",
    "? ",
    ": ",
    "- ",
    "\t",
    "{",
    "[",
    "'",
    '"',
    "|\n",
    "<<: *a\n",
    "%YAML 9\n",
    "---\n",
    "\x00",
    "\ufeff",
    "1e9999",
    "0x",
    "@",
)
_DEEP = 3000


def spoiled_yaml(text: str, drawn: random.Random) -> bytes:
    """Return a YAML text with some of its values, or of its characters, changed."""
    if drawn.random() < 0.7:
        try:
            return _dumped(_changed(yaml.safe_load(text), drawn, drawn.randint(1, 3)), drawn)
        except (yaml.YAMLError, RecursionError):
            pass
    return spoiled_text(text, drawn)


def spoiled_json(text: str, drawn: random.Random) -> bytes:
    """Return a JSON text with some of its values, or of its characters, changed."""
    if drawn.random() < 0.7:
        return json.dumps(_changed(json.loads(text), drawn, drawn.randint(1, 3)), default=str).encode(
            "utf-8", "replace"
        )
    return spoiled_text(text, drawn)


def spoiled_text(text: str, drawn: random.Random) -> bytes:
    """Return a string with tokens inserted, lines moved, parts removed or repeated, or nested deeply."""
    for _ in range(drawn.randint(1, 4)):
        at, end = sorted((drawn.randint(0, len(text)), drawn.randint(0, len(text))))
        ways: tuple[Callable[[], str], ...] = (
            lambda: text[:at] + drawn.choice(_TOKENS) + text[at:],  # noqa: B023 - called in this turn
            lambda: text[:at] + text[end:],  # noqa: B023
            lambda: text[:end] + text[at:end] + text[end:],  # noqa: B023
            lambda: text[:at] + drawn.choice(_STRINGS) + text[at:],  # noqa: B023
            lambda: text[:at],  # noqa: B023
            lambda: text[:at] + "[" * _DEEP + text[at:],  # noqa: B023
        )
        text = drawn.choice(ways)()
    return (
        spoiled_bytes(text.encode("utf-8", "replace"), drawn)
        if drawn.random() < 0.2
        else text.encode("utf-8", "replace")
    )


def spoiled_bytes(data: bytes, drawn: random.Random) -> bytes:
    """Return bytes with some flipped, removed or repeated."""
    spoiled = bytearray(data)
    for _ in range(drawn.randint(1, 6)):
        if not spoiled:
            break
        at = drawn.randrange(len(spoiled))
        way = drawn.randrange(4)
        if way == 0:
            spoiled[at] ^= 1 << drawn.randrange(8)
        elif way == 1:
            del spoiled[at:]
        elif way == 2:
            spoiled[at:at] = spoiled[at : at + drawn.randint(1, 200)]
        else:
            spoiled[at : at + 8] = drawn.randbytes(8)
    return bytes(spoiled)


def _changed(value: Any, drawn: random.Random, n: int) -> Any:
    """Return a tree of lists and mappings with ``n`` of its places changed."""
    for _ in range(n):
        places = list(_places(value))
        if not places:
            return hostile(drawn)
        owner, key = drawn.choice(places)
        way = drawn.random()
        if way < 0.6:
            owner[key] = _nudged(owner[key], drawn)
        elif way < 0.75:
            del owner[key]
        elif way < 0.9 and isinstance(owner, dict):
            owner[drawn.choice(_STRINGS)] = owner.pop(key)
        else:
            owner[key] = [owner[key]] * drawn.choice((2, 500))
    return value


def _places(value: Any) -> Any:
    """Yield the list or mapping and the index or key of every value."""
    found = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in list(found):
        yield value, key
        yield from _places(inner)


def _nudged(value: Any, drawn: random.Random) -> Any:
    """Return a number times a power of ten or with another sign, so that it may pass; else something hostile."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if is_number and drawn.random() < 0.6:
        return value * drawn.choice((-1, 0, 0.1, 2, 10, 100, 1_000, 10**6, 10**8, 1e-6))
    return hostile(drawn)


def hostile(drawn: random.Random) -> Any:
    """Return a value that is not what is expected: of another type, too large, not finite, or hostile text."""
    kind = drawn.randrange(6)
    if kind < 2:
        return drawn.choice(_NUMBERS)
    if kind < 4:
        return drawn.choice(_STRINGS)
    if kind == 4:
        return drawn.choice((None, [], {}, [[]], {"": None}, [1, 2, 3], {"use": "plane.ica"}))
    return drawn.uniform(-1e3, 1e3)


def _dumped(value: Any, drawn: random.Random) -> bytes:
    text = yaml.safe_dump(value, allow_unicode=drawn.random() < 0.5, sort_keys=drawn.random() < 0.5)
    return text.encode("utf-8", "replace")
