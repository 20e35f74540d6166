"""The range in which a parameter is searched, and its fit to the type and bounds of the parameter."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin

from graphnav import ParamError, Place, Problem, UserError
from graphnav.core.graph import Override, Target
from graphnav.core.stage import Param

FACTOR = 4.0
"""A number is searched from its default divided by this to its default times this, within its bounds."""
DIGITS = 4
"""Significant digits of a searched number: more are noise, and would be copied into graphs."""
_HINT = (
    "write --search plane.threshold_px=0.05:2, --search plane.threshold_px=0.05:2:log or --search plane.rule=mad,otsu"
)
_SPAN = re.compile(r"\s*(?P<low>[^:]+):(?P<high>[^:]+?)(?P<log>:log)?\s*")

Choice = str | int | float | bool


@dataclass(frozen=True)
class SearchRange:
    """The values of one parameter: a span of numbers, or a list of choices."""

    target: str
    """``stage.parameter``, as ``--set`` takes it."""
    kind: Literal["number", "integer", "choice"]
    low: float = 0.0
    high: float = 0.0
    is_log: bool = False
    choices: tuple[Choice, ...] = ()

    @property
    def text(self) -> str:
        """The range as ``--search`` takes it."""
        if self.kind == "choice":
            return f"{self.target}={','.join(_shown(choice) for choice in self.choices)}"
        return f"{self.target}={_number(self.low)}:{_number(self.high)}{':log' if self.is_log else ''}"

    @property
    def parts(self) -> frozenset[str]:
        """The parameters of one stage each that it sets."""
        return parts_of(self.target)

    def has_place(self, value: Any) -> bool:
        """Return whether the range has a value that ``value`` could stand for: it is a choice, or any number."""
        return value in self.choices if self.kind == "choice" else isinstance(value, int | float)

    def clipped(self, value: Any) -> Any:
        """Return the value of the range that is nearest to one that has a place in it."""
        if self.kind == "choice":
            return value
        number = min(max(float(value), self.low), self.high)
        return round(number) if self.kind == "integer" else number

    def rounded(self, value: Any) -> Any:
        """Return a value as it is written into a graph."""
        if self.kind != "number":
            return value
        return min(max(float(f"{value:.{DIGITS}g}"), self.low), self.high)


def parts_of(target: str) -> frozenset[str]:
    """Return ``plane.rule`` and ``twin.rule`` of ``plane,twin.rule``."""
    stages, _, key = target.rpartition(".")
    return frozenset(f"{stage}.{key}" for stage in stages.split(","))


def parse_searches(texts: Iterable[str], problems: list[Problem]) -> tuple[SearchRange, ...]:
    """Return the ranges of ``--search``; what is wrong with them is added to ``problems``."""
    found: list[SearchRange] = []
    for text in texts:
        place = Place(f"--search {text}")
        try:
            searched = parse_search(text, place)
        except UserError as error:
            problems += error.problems
            continue
        if first := next((one for one in found if one.parts & searched.parts), None):
            what = f"'{searched.target}' is searched twice, first by '{first.text}'"
            problems.append(Problem(place, what, "keep one", "duplicate"))
        found.append(searched)
    return tuple(found)


def parse_search(text: str, place: Place) -> SearchRange:
    """Return the range of ``TARGET=LOW:HIGH``, ``TARGET=LOW:HIGH:log`` or ``TARGET=a,b``.

    Raises
    ------
    UserError
        It has none of these forms, or the range is empty.
    """
    name, equals, listed = text.partition("=")
    target = Target.parse(name.strip(), place) if equals and name.strip() else None
    if target is None or target.kind != "setting" or not listed.strip():
        raise UserError.of("this does not name a parameter and its values", _HINT, place)
    span = _SPAN.fullmatch(listed)
    if span is None:
        choices = tuple(Override.parse_value(one.strip(), place) for one in listed.split(","))
        if not all(isinstance(one, str | int | float) for one in choices):
            raise UserError.of("a choice is a string, a number, true or false", _HINT, place)
        if len({(type(one), one) for one in choices}) < len(choices):
            raise UserError.of("a choice is written twice", "keep one: each is tried as often as the others", place)
        return SearchRange(str(target), "choice", choices=choices)
    low, high = (Override.parse_value(span[name].strip(), place) for name in ("low", "high"))
    for number in (low, high):
        if isinstance(number, bool) or not isinstance(number, int | float) or not math.isfinite(number):
            raise UserError.of(f"'{number}' is not a number", _HINT, place)
    if low >= high:
        raise UserError.of(f"the range ends at {high}, where it begins or before", _HINT, place)
    if span["log"] and low <= 0:
        raise UserError.of(f"a logarithmic range must begin above 0, not at {low}", _HINT, place)
    return SearchRange(str(target), "number", low, high, is_log=bool(span["log"]))


def range_of(target: str, param: Param, center: Any) -> SearchRange | None:
    """Return the range around a parameter's value, None where nothing says what its values could be.

    A positive number is searched by `FACTOR` to either side, on a logarithmic scale, an integer on a linear one; zero
    and negative numbers between their bounds, if there are two. Paths, strings and lists are not searched, nor what is
    null.
    """
    kind = plain_type(param.type)
    if kind is bool:
        return SearchRange(target, "choice", choices=(True, False))
    if get_origin(kind) is Literal:
        return SearchRange(target, "choice", choices=get_args(kind))
    if kind not in (int, float) or center is None:
        return None
    low, high = _bounds(param, center, is_integer=kind is int)
    if center > 0:
        low, high = max(low, center / FACTOR), min(high, center * FACTOR)
    if not (math.isfinite(low) and math.isfinite(high)):
        return None
    if kind is int:
        return SearchRange(target, "integer", math.ceil(low), math.floor(high))
    return SearchRange(target, "number", low, high, is_log=low > 0)


def _bounds(param: Param, center: float, *, is_integer: bool) -> tuple[float, float]:
    """Return the minimum and maximum that a parameter may have; infinite where it has none.

    ``center``: its value, from which an exclusive minimum is a thousandth of the way away.
    """
    low = max((bound for bound in (param.ge, param.gt) if bound is not None), default=-math.inf)
    high = min((bound for bound in (param.le, param.lt) if bound is not None), default=math.inf)
    if param.gt == low:
        low = low + 1 if is_integer else _inside(low, center if center > low else high)
    if param.lt == high:
        high = high - 1 if is_integer else _inside(high, low)
    return low, high


def _inside(bound: float, other: float) -> float:
    """Return a number that is within an exclusive bound."""
    width = abs(other - bound) if math.isfinite(other) else max(abs(bound), 1.0)
    return bound + math.copysign(1e-3 * width, other - bound)


def plain_type(kind: Any) -> Any:
    """Return the type of what may be null without null, and any other type as it is."""
    if get_origin(kind) in (Union, UnionType):
        others = [one for one in get_args(kind) if one is not NoneType]
        return others[0] if len(others) == 1 else None
    return kind


def _number(number: float) -> str:
    return str(number) if isinstance(number, int) else f"{number:.12g}"


def _shown(choice: Choice) -> str:
    return str(choice).lower() if isinstance(choice, bool) else str(choice)


def fitted(searched: SearchRange, param: Param) -> SearchRange:
    """Return a range with the type of its parameter: ``1:4`` of a float has all numbers from 1 to 4.

    Raises
    ------
    UserError
        An end or a choice that the parameter may not have: every trial of it would be refused.
    """
    place = Place(f"--search {searched.text}")
    problems = []
    for value in searched.choices or (searched.low, searched.high):
        try:
            param.parse(value)
        except ParamError as error:
            bounds = f", {param.bounds_text}" if param.bounds_text else ""
            problems.append(Problem(place, error.what, error.hint or f"'{param.name}' is {param.type_text}{bounds}"))
    if problems:
        raise UserError(problems)
    if searched.kind == "choice":
        return searched
    return replace(searched, kind="integer" if plain_type(param.type) is int else "number")
