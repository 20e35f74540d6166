"""Read a value of a file as a declared record; everything that is wrong is collected, each with its place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, TypeVar, Union, get_args

from graphnav.core.errors import Hint, ParamError, Place, Problem, did_you_mean
from graphnav.core.spec.declared.kinds import (
    fits,
    is_list,
    is_mapping,
    is_range,
    is_record,
    is_union,
    positions_of,
    said,
)
from graphnav.core.spec.declared.record import Key, Path, Range, Record, Written, keys_of
from graphnav.core.spec.value import Entry, Value

R = TypeVar("R", bound=Record)
WRONG: Final = object()
"""Stands for a value that has an error."""


@dataclass(frozen=True)
class _At:
    """Where the reader is: in which declared key, what messages call the value, and its path."""

    key: Key
    name: str
    path: Path

    def into(self, part: str, name: str) -> _At:
        return _At(self.key, name, (*self.path, part))


def read_record(cls: type[R], value: Value) -> tuple[R | None, list[Problem]]:
    """Return what a value says, and everything that is wrong with it.

    What is wrong is as if it were not given, so that the rest can be checked further; a list loses the records that
    are wrong. None: something that is required is wrong or missing.
    """
    reader = _Reader()
    found = reader.record(cls, value, (), cls.noun)
    return (None if found is WRONG else found), reader.problems


class _Reader:
    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self._places: dict[Path, Place] = {}
        self._keys: dict[Path, Place] = {}

    def record(self, cls: type[R], value: Value, path: Path, name: str) -> Any:
        self._places[path] = value.place
        if not isinstance(value.data, dict):
            hint = f"its keys are {', '.join(keys_of(cls))}"
            return self._wrong(value.place, f"{name} must be a mapping, not {value.kind}", hint)
        keys = keys_of(cls)
        self._keys |= {(*path, word): entry.place for word, entry in value.data.items()}
        unknown = self._unknown(cls, value.data)
        found = {
            word: self._read(keys[word].type, entry.value, _At(keys[word], word, (*path, word)))
            for word, entry in value.data.items()
            if word in keys
        }
        needed = [word for word, one in keys.items() if one.required]
        for word in needed:
            if word not in found and word not in unknown.values():
                hint = keys[word].hint or f"write {word}: {said(keys[word].type)}"
                self._wrong(value.place, f"{cls.noun} needs '{word}': {keys[word].doc}", hint)
        is_clear = self._one_of(cls, value, found, unknown) and found.keys() >= {*needed}
        right = {word: one for word, one in found.items() if one is not WRONG}
        if not is_clear or found.keys() - right.keys() & {*needed, *cls.one_of}:
            return WRONG
        return cls(**right, written=Written(self._places, self._keys, path))

    def _unknown(self, cls: type[Record], data: Mapping[str, Entry]) -> dict[str, str]:
        """Return the keys that are not declared, each with the one that seems to be meant, or nothing."""
        keys, unknown = keys_of(cls), {}
        for word, entry in data.items():
            if word not in keys:
                near = did_you_mean(word, keys, cls.renamed)
                self._wrong(entry.place, f"{cls.noun} has no key '{word}'", near or f"keys are {', '.join(keys)}")
                unknown[word] = near.names[0] if near else ""
        return unknown

    def _one_of(self, cls: type[Record], value: Value, found: Mapping[str, Any], unknown: Mapping[str, str]) -> bool:
        """Return whether exactly one of ``cls.one_of`` is given."""
        given = [word for word in cls.one_of if found.get(word) is not None]
        if len(given) > 1:
            place = value.data[given[1]].place if isinstance(value.data, dict) else value.place
            self._wrong(place, f"{cls.noun} has {' and '.join(map(repr, given))}", "keep one of them")
        elif cls.one_of and not given and not unknown:
            hint = keys_of(cls)[cls.one_of[0]].hint
            self._wrong(value.place, f"{cls.noun} needs one of {', '.join(cls.one_of)}", hint)
        return len(given) == min(len(cls.one_of), 1)

    def _read(self, kind: Any, value: Value, at: _At) -> Any:
        self._places[at.path] = value.place
        if kind is Value:
            return value
        if is_union(kind):
            return self._member(kind, value, at)
        if is_range(kind):
            return self._range(get_args(kind)[0], value, at)
        if is_record(kind):
            return self.record(kind, value, at.path, f"'{at.name}'")
        if is_mapping(kind):
            return self._names(get_args(kind)[1], value, at)
        if is_list(kind):
            return self._list(kind, value, at)
        return self._tuple(kind, value, at) if positions_of(kind) else self._scalar(kind, value, at)

    def _member(self, kind: Any, value: Value, at: _At) -> Any:
        if value.data is None and type(None) in get_args(kind):
            return None
        members = [member for member in get_args(kind) if member is not type(None)]
        if len(members) == 1:
            return self._read(members[0], value, at)
        fitting = [member for member in members if fits(member, value)]
        if not fitting:
            return self._not(kind, value, at)
        if isinstance(value.data, dict | list):
            return self._read(fitting[0], value, at)
        try:
            return at.key.as_param(Union[*fitting], at.name).parse(value.data)
        except ParamError:
            return self._not(kind, value, at)

    def _range(self, kind: Any, value: Value, at: _At) -> Any:
        if isinstance(value.data, list) and len(value.data) != 2:
            return self._not(Range[kind], value, at)
        ends = value.data if isinstance(value.data, list) else [value]
        numbers = [self._scalar(kind, end, at) for end in ends]
        if WRONG in numbers:
            return WRONG
        low, high = numbers[0], numbers[-1]
        if low > high:
            what = f"the range of '{at.name}' begins with its larger end"
            return self._wrong(value.place, what, f"write [{high:g}, {low:g}]")
        return Range(low, high, at.path)

    def _names(self, kind: Any, value: Value, at: _At) -> Any:
        if not isinstance(value.data, dict):
            return self._not(Mapping[str, kind], value, at)
        self._keys |= {(*at.path, name): entry.place for name, entry in value.data.items()}
        read = {name: self._read(kind, entry.value, at.into(name, name)) for name, entry in value.data.items()}
        return {name: one for name, one in read.items() if one is not WRONG}

    def _list(self, kind: Any, value: Value, at: _At) -> Any:
        if not isinstance(value.data, list):
            return self._not(kind, value, at)
        if len(value.data) < at.key.min_items:
            has = f"has {len(value.data)} items, but needs at least {at.key.min_items}"
            return self._wrong(value.place, f"'{at.name}' {has if value.data else 'is an empty list'}", at.key.hint)
        member = get_args(kind)[0]
        read = [
            self._read(member, item, at.into(str(index), f"{at.name}[{index}]"))
            for index, item in enumerate(value.data)
        ]
        if is_record(member):
            return tuple(one for one in read if one is not WRONG)
        return WRONG if WRONG in read else tuple(read)

    def _tuple(self, kind: Any, value: Value, at: _At) -> Any:
        positions = positions_of(kind)
        if not isinstance(value.data, list) or len(value.data) != len(positions):
            return self._not(kind, value, at)
        read = [
            self._read(member, item, at.into(name, f"{at.name}.{name}"))
            for item, (name, member) in zip(value.data, positions.items(), strict=True)
        ]
        return WRONG if WRONG in read else kind(*read)

    def _scalar(self, kind: Any, value: Value, at: _At) -> Any:
        if isinstance(value.data, dict | list):
            return self._not(kind, value, at)
        try:
            return at.key.as_param(kind, at.name).parse(value.data)
        except ParamError as error:
            return self._wrong(value.place, error.what, error.hint)

    def _not(self, kind: Any, value: Value, at: _At) -> Any:
        count = f" of {len(value.data)}" if isinstance(value.data, list) else ""
        return self._wrong(value.place, f"'{at.name}' must be {said(kind)}, not {value.kind}{count}", at.key.hint)

    def _wrong(self, place: Place, what: str, hint: Hint = "") -> Any:
        self.problems.append(Problem(place, what, hint))
        return WRONG
