"""Publish messages whose fields are given as YAML; fields that are not given are zero or empty."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from graphnav import Place, Problem, UserError, Value, did_you_mean
from graphnav.core.bus import Bus
from graphnav.core.codec import EncodeError, Field, codec_of, fields_of, lcm_name
from graphnav.core.spec import Entry, parse_yaml

SOURCE = "FIELDS"
"""Name of the command-line argument in errors."""
_MAX_FILLED = 1_000_000
"""Maximum number of elements of an array of which only the size is given."""
_INTEGERS: Mapping[str, tuple[int, int]] = {
    "int8_t": (-(2**7), 2**7 - 1),
    "int16_t": (-(2**15), 2**15 - 1),
    "int32_t": (-(2**31), 2**31 - 1),
    "int64_t": (-(2**63), 2**63 - 1),
    "byte": (0, 255),
}
_FLOAT_MAX = float(np.finfo(np.float32).max)
ZEROS: Mapping[str, Any] = {**dict.fromkeys(_INTEGERS, 0), "float": 0.0, "double": 0.0, "boolean": False, "string": ""}
"""Value of a field that is not given."""
_SAME_S = 1e-6
"""Times closer than this are equal: multiples of a period are not exact."""


class Fields(NamedTuple):
    """All fields of a message, and the names of those that were given."""

    values: dict[str, Any]
    given: frozenset[str]


def parse_fields(text: str, lcm_class: type) -> Fields:
    """Return the fields of a message; ``text`` is a YAML mapping, with or without its braces.

    Raises
    ------
    UserError
        It is not YAML, or does not match the type: all problems with line and column.
    """
    value = _parsed(text)
    if value.data is not None and not isinstance(value.data, dict):
        names = ", ".join(field.name for field in fields_of(lcm_class))
        hint = f"write name: value; fields are {names}"
        raise UserError.of(f"{SOURCE} must be a mapping, not {value.kind}", hint)
    problems: list[Problem] = []
    values = _struct(value, lcm_class, problems)
    if problems:
        raise UserError(problems)
    given = frozenset(value.data or {})
    try:
        codec_of(lcm_class).encode(values)
    except EncodeError as error:
        raise UserError.of(str(error), "give arrays the sizes that the type declares", Place(SOURCE)) from error
    return Fields(values, given)


def _parsed(text: str) -> Value:
    """Return the mapping; braces are added to a single line without them, as in ``v_mps: 0.2, omega_radps: 0``."""
    is_bare = not text.lstrip().startswith("{") and "\n" not in text.strip()
    if is_bare and (other := _not_a_mapping(text)) is not None:
        return other
    data = (f"{{{text}\n}}" if is_bare else text).encode("utf-8", "surrogateescape")
    try:
        value, problems = parse_yaml(data, SOURCE)
    except UserError as error:
        raise UserError([_moved(problem, is_bare=is_bare) for problem in error.problems]) from error
    if problems:
        raise UserError([_moved(problem, is_bare=is_bare) for problem in problems])
    return _without_brace(value) if is_bare else value


def _not_a_mapping(text: str) -> Value | None:
    """Return the value of a line that is YAML without braces but not a mapping: a number, a list; None for others."""
    try:
        value, problems = parse_yaml(text.encode("utf-8", "surrogateescape"), SOURCE)
    except UserError:
        return None
    return None if problems or value.data is None or isinstance(value.data, dict) else value


def _moved(problem: Problem, *, is_bare: bool) -> Problem:
    if not is_bare or problem.place is None:
        return problem
    return Problem(_place(problem.place), problem.what, problem.hint, problem.kind, problem.raised)


def _place(place: Place) -> Place:
    """Return the location in the original line of a location in the line with braces."""
    return place._replace(column=max(1, place.column - 1)) if place.line == 1 else Place(SOURCE)


def _without_brace(value: Value) -> Value:
    if isinstance(value.data, list):
        return Value([_without_brace(item) for item in value.data], _place(value.place))
    if isinstance(value.data, dict):
        entries = {key: Entry(_place(one.place), _without_brace(one.value)) for key, one in value.data.items()}
        return Value(entries, _place(value.place))
    return Value(value.data, _place(value.place))


def _struct(value: Value, lcm_class: type, problems: list[Problem]) -> dict[str, Any]:
    """Return all fields of a struct; errors are appended to ``problems``."""
    fields = {field.name: field for field in fields_of(lcm_class)}
    if value.data is not None and not isinstance(value.data, dict):
        what = f"{lcm_name(lcm_class)} needs fields, not {value.kind}"
        problems.append(Problem(value.place, what, "write name: value, name: value"))
        return {}
    entries = value.data or {}
    for name, entry in entries.items():
        if name not in fields:
            hint = did_you_mean(name, fields) or f"fields are {', '.join(fields)}"
            problems.append(Problem(entry.place, f"{lcm_name(lcm_class)} has no field '{name}'", hint))
    given = {
        name: _given(field, field.dims, entries[name].value, problems)
        for name, field in fields.items()
        if name in entries
    }
    for name, written in given.items():
        if any(len(lengths) > 1 for lengths in _lengths(written, len(fields[name].dims))):
            problems.append(Problem(entries[name].place, f"the lists in '{name}' differ in length", "make them equal"))
    sizes = _sizes(fields, given)
    missing = [field for name, field in fields.items() if name not in given and name not in sizes]
    for field in missing:
        shape = [dim if isinstance(dim, int) else sizes[dim] for dim in field.dims]
        if math.prod(shape) > _MAX_FILLED or min(shape, default=0) < 0:
            problems.append(Problem(value.place, f"'{field.name}' would have the shape {shape}", "write smaller sizes"))
            return {}
    return given | sizes | {field.name: _zero(field, sizes) for field in missing}


def _given(field: Field, dims: tuple[int | str, ...], value: Value, problems: list[Problem]) -> Any:
    """Return the value of a field, or of one of its sub-arrays."""
    if dims:
        if not isinstance(value.data, list):
            axes = "".join(f"[{dim}]" for dim in field.dims)
            what = f"'{field.name}' must be an array {field.primitive}{axes}, not {value.kind}"
            problems.append(Problem(value.place, what, "write [value, value]" if len(dims) == 1 else "write [[value]]"))
            return []
        if isinstance(dims[0], int) and len(value.data) != dims[0]:
            what = f"'{field.name}' must hold {dims[0]} values here, not {len(value.data)}"
            problems.append(Problem(value.place, what, f"write {dims[0]} values"))
        return [_given(field, dims[1:], item, problems) for item in value.data]
    if field.struct is not None:
        return _struct(value, field.struct, problems)
    problem = scalar_problem(field.name, field.primitive, value)
    if problem is not None:
        problems.append(problem)
        return ZEROS[field.primitive]
    return float(value.data) if field.primitive in {"float", "double"} else value.data  # type: ignore[arg-type]


def _sizes(fields: dict[str, Field], given: dict[str, Any]) -> dict[str, int]:
    """Return the sizes of arrays that are not given: those of the given arrays, else 0."""
    found: dict[str, int] = {}
    for name, field in fields.items():
        lengths = _lengths(given.get(name), len(field.dims))
        for dim, there in zip(field.dims, lengths, strict=True):
            if isinstance(dim, str):
                found[dim] = max(found.get(dim, 0), *there, 0)
    return {dim: given.get(dim, size) for dim, size in found.items()}


def _lengths(value: Any, axes: int) -> list[set[int]]:
    """Return the lengths of the lists along each axis of nested lists."""
    lengths: list[set[int]] = []
    level = [value]
    for _ in range(axes):
        lists = [part for part in level if isinstance(part, list)]
        lengths.append({len(part) for part in lists})
        level = [item for part in lists for item in part]
    return lengths


def _zero(field: Field, sizes: dict[str, int]) -> Any:
    """Return zeros, or empty strings, of the field's type and shape."""

    def below(dims: tuple[int | str, ...]) -> Any:
        if dims:
            size = dims[0] if isinstance(dims[0], int) else sizes[dims[0]]
            return [below(dims[1:]) for _ in range(size)]
        if field.struct is None:
            return ZEROS[field.primitive]
        return _struct(Value({}, Place(SOURCE)), field.struct, [])

    return below(field.dims)


def scalar_problem(name: str, primitive: str, value: Value) -> Problem | None:
    """Return the problem with the value of a field, None if it matches the type."""
    data = value.data
    if primitive in _INTEGERS:
        return _integer_problem(name, primitive, value)
    if primitive == "boolean":
        fits, wanted, hint = isinstance(data, bool), "a boolean", "write true or false"
    elif primitive == "string":
        hint = "put it in quotes" if isinstance(data, bool | int | float) else "write a string"
        fits, wanted = isinstance(data, str), "a string"
    else:
        fits, wanted, hint = (
            isinstance(data, int | float) and not isinstance(data, bool),
            f"a number ({primitive})",
            "write a number",
        )
    if not fits:
        return Problem(value.place, f"'{name}' must be {wanted}, not {value.kind}", hint)
    if primitive in {"float", "double"} and isinstance(data, int | float):
        if not math.isfinite(data):
            return Problem(value.place, f"'{name}' is not finite: {data}", "write a finite number")
        if primitive == "float" and abs(data) > _FLOAT_MAX:
            return Problem(
                value.place,
                f"'{name}' is {data}, but the maximum of float is {_FLOAT_MAX:.6g}",
                "write a smaller number",
            )
    return None


def _integer_problem(name: str, primitive: str, value: Value) -> Problem | None:
    data, (smallest, largest) = value.data, _INTEGERS[primitive]
    if isinstance(data, bool) or not isinstance(data, int):
        what = f"'{name}' must be an integer ({primitive}), not {value.kind}"
        return Problem(value.place, what, "write an integer")
    if not smallest <= data <= largest:
        what = f"'{name}' is {data}, but the range of {primitive} is {smallest} to {largest}"
        return Problem(value.place, what, "write an integer in this range")
    return None


class Publisher:
    """Publishes a message on a channel.

    If its type has ``utime`` and ``seq`` and they are not given, ``utime`` is the time of day in microseconds and
    ``seq`` counts from 0. ``count``: number of messages published.
    """

    def __init__(
        self, bus: Bus, channel: str, lcm_class: type, fields: Fields, now_ns: Callable[[], int] = time.time_ns
    ) -> None:
        self.count = 0
        self._bus, self._channel, self._now_ns = bus, channel, now_ns
        self._codec, self._values = codec_of(lcm_class), dict(fields.values)
        stamps = {field.name for field in fields_of(lcm_class) if field.primitive == "int64_t" and not field.dims}
        self._filled = ({"utime", "seq"} & stamps) - fields.given

    def publish(self) -> None:
        """Send the next message; raises BusError if the network refuses it."""
        if "utime" in self._filled:
            self._values["utime"] = self._now_ns() // 1000
        if "seq" in self._filled:
            self._values["seq"] = self.count
        self._bus.send(self._channel, self._codec.encode(self._values))
        self.count += 1


def repeat(
    publish: Callable[[], None],
    rate_hz: float,
    n: int | None = None,
    for_s: float | None = None,
    now_s: Callable[[], float] = time.monotonic,
    sleep: Callable[[float], None] = time.sleep,
) -> None:
    """Call ``publish`` at a rate, ``n`` times, for ``for_s`` seconds, or until something raises.

    A late call delays the following ones: missed calls are not made up for.
    """
    begin_s = due_s = now_s()
    count = 0
    while n is None or count < n:
        if for_s is not None and due_s - begin_s > for_s - _SAME_S:
            return
        if (wait_s := due_s - now_s()) > 0:
            sleep(wait_s)
        publish()
        count += 1
        due_s = max(due_s + 1 / rate_hz, now_s())
