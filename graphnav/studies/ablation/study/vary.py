"""Changes to the axes of a study, as the command line and Python give them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from graphnav.core.errors import Place, Problem, UserError
from graphnav.core.graph import Override, parse_override, parse_value
from graphnav.core.spec import write_value

_HINT = "write AXIS=first,second for a new axis, AXIS+=value to add to one of the study"
_OPENING, _CLOSING = "[{", "]}"
_ADDED = "+"


@dataclass(frozen=True)
class VaryValue:
    """One value: plain YAML data, and how tables show it."""

    value: Any
    shown: str
    place: Place
    override: Override | None = None
    """The same read as ``target=value``, None where it has another form."""

    @property
    def label(self) -> str:
        """The label that it may name among the choices of an axis."""
        return self.value if isinstance(self.value, str) else self.shown


@dataclass(frozen=True)
class Vary:
    """A new axis, another one in place of an axis of the study, or choices to add to one."""

    axis: str
    values: tuple[VaryValue, ...]
    place: Place
    is_added: bool = False

    @property
    def words(self) -> str:
        """``AXIS=first,second``, as ``--vary`` takes it."""
        adds = _ADDED if self.is_added else ""
        return f"{self.axis}{adds}={','.join(value.shown for value in self.values)}"


def vary_of(name: str, values: Iterable[Any], place: Place) -> Vary:
    """Return the change that plain data means; ``AXIS+`` adds to an axis."""
    found = tuple(VaryValue(value, write_value(value), place) for value in values)
    return Vary(name.removesuffix(_ADDED).strip(), found, place, is_added=name.endswith(_ADDED))


def parse_varies(texts: Iterable[str], problems: list[Problem]) -> tuple[Vary, ...]:
    """Return the changes of ``--vary AXIS=first,second`` and ``AXIS+=another``; what is wrong goes to ``problems``."""
    found = []
    for text in texts:
        try:
            found.append(_parse(text, Place(f"--vary {text}")))
        except UserError as error:
            problems += error.problems
    return tuple(found)


def split_values(text: str) -> Iterator[str]:
    """Yield what is between commas that are in no brackets and no quotes."""
    depth, quote, start = 0, "", 0
    for number, char in enumerate(text):
        if quote:
            quote = "" if char == quote else quote
        elif char in "\"'" and (depth > 0 or not text[start:number].strip()):
            quote = char
        elif char in _OPENING:
            depth += 1
        elif char in _CLOSING:
            depth -= 1
        elif char == "," and depth <= 0:
            yield text[start:number]
            start = number + 1
    yield text[start:]


def _parse(text: str, place: Place) -> Vary:
    name, equals, listed = text.partition("=")
    values = [value.strip() for value in split_values(listed)]
    axis = name.removesuffix(_ADDED).strip()
    if not equals or not axis:
        raise UserError.of("this does not name an axis and its values", _HINT, place)
    if "" in values:
        raise UserError.of(f"axis '{axis}' has no values" if len(values) == 1 else "a value is empty", _HINT, place)
    found = [_value(value, Place(place.file, 0, number)) for number, value in enumerate(values, 1)]
    return Vary(axis, tuple(found), place, is_added=name.endswith(_ADDED))


def _value(text: str, place: Place) -> VaryValue:
    override = None
    with suppress(UserError):
        override = parse_override(text, place)
    return VaryValue(parse_value(text, place), text, place, override)
