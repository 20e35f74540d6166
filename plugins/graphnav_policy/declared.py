"""Inputs and outputs of a network as a graph declares them: fields of the messages on ports."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from graphnav import Message, NumericField, ParamError, did_you_mean, messages_by_name, numeric_layout

Words = str | tuple[str, ...]
_PORT = re.compile(r"[a-z][a-z0-9_]*")


class FieldOf(NamedTuple):
    """A numeric field of the message on a port."""

    port: str
    message: type[Message]
    name: str
    layout: NumericField

    def __str__(self) -> str:
        """Return it as graphs write it."""
        return f"{self.port}.{self.name}"


class Declared(NamedTuple):
    """A tensor of a network and what it holds: one field in its own shape, several in a row, or a ``constant``."""

    name: str
    fields: tuple[FieldOf, ...]
    constant: float | None = None


def message_of(port: str) -> type[Message] | None:
    """Return the message of a port, whose name it has in small letters, alone or before ``_``; the longest that fits.

    ``image`` and ``image_left`` are ports of `Image`, ``local_map`` one of `LocalMap`.
    """
    named = messages_by_name()
    parts = port.split("_") if _PORT.fullmatch(port) else []
    return next((named[stem] for n in range(len(parts), 0, -1) if (stem := "_".join(parts[:n])) in named), None)


def read_declared(param: str, words: Mapping[str, Words | float], problems: list[ParamError]) -> dict[str, Declared]:
    """Return what ``inputs`` or ``outputs`` say by the names of the network; what is wrong is added to ``problems``."""
    found = {}
    for name, given in words.items():
        if isinstance(given, int | float):
            found[name] = Declared(name, (), float(given))
            continue
        fields = [read_field(param, word, problems) for word in ([given] if isinstance(given, str) else given)]
        if not fields:
            problems.append(ParamError(param, f"'{name}' has no fields", f"write {name}: port.field"))
        found[name] = Declared(name, tuple(field for field in fields if field is not None))
    return found


def read_field(param: str, word: str, problems: list[ParamError]) -> FieldOf | None:
    """Return the field that ``port.field`` means, None if it means none, which is added to ``problems``."""
    port, dot, name = word.partition(".")
    if not dot:
        what = f"'{word}' in '{param}' is not port.field"
        problems.append(ParamError(param, what, "write port.field, such as image.pixels"))
        return None
    message = message_of(port)
    if message is None:
        hint = did_you_mean(port, messages_by_name()) or "name it for its message, as image or image_left for an Image"
        problems.append(ParamError(param, f"'{word}' in '{param}': no message is called '{port}'", hint))
        return None
    layout = numeric_layout(message)
    if name not in layout:
        hint = did_you_mean(name, layout) or f"its numeric fields are {', '.join(layout) or 'none'}"
        what = f"'{word}' in '{param}': {message.__name__} has no numeric field '{name}'"
        problems.append(ParamError(param, what, hint))
        return None
    return FieldOf(port, message, name, layout[name])


def ports_in(declared: Iterable[Declared]) -> dict[str, type[Message]]:
    """Return the ports of tensors with their messages, in the order in which they are named."""
    return {field.port: field.message for one in declared for field in one.fields}


def as_group(problems: list[ParamError]) -> None:
    """Raise what is wrong, if anything is: one `ParamError`, or a group of several."""
    if len(problems) == 1:
        raise problems[0]
    if problems:
        raise ExceptionGroup("parameters", problems)
