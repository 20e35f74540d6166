"""Read a value of a file as a declared record; everything that is wrong is collected, each with its place."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
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
_QUOTES = "put it in quotes if it is meant"


@dataclass(frozen=True)
class _At:
    """Where the reader is: in which declared key, what messages call the value, and its path."""

    key: Key
    name: str
    path: Path
    who: str = ""
    """Before messages, the named record that it is in: "stage 'flow': "."""

    def into(self, part: str, name: str) -> _At:
        return replace(self, name=name, path=(*self.path, part))


def read_record(cls: type[R], value: Value) -> tuple[R | None, list[Problem]]:
    """Return what a value says, and everything that is wrong with it.

    What is wrong is as if it were not given, so that the rest can be checked further; a list loses the records that
    are wrong. None: something that is required is wrong or missing.
    """
    reader = _Reader()
    found = reader.record(cls, value, (), cls.noun)
    return (None if found is WRONG else found), reader.problems


def key_problems(cls: type[Record], name: str, word: str, value: Value) -> list[Problem]:
    """Return what is wrong with the value of one key of the record of a name, where the others are not known."""
    reader, key = _Reader(), keys_of(cls)[word]
    reader.read(key.type, value, _At(key, word, (word,), f"{cls.named.format(name)}: "))
    return reader.problems


class _Reader:
    def __init__(self) -> None:
        self.problems: list[Problem] = []
        self._places: dict[Path, Place] = {}
        self._keys: dict[Path, Place] = {}

    def record(self, cls: type[R], value: Value, path: Path, name: str, named: Entry | None = None) -> Any:
        """Return a record; ``name``: what messages call the value; ``named``: its entry, where its name is free."""
        self._places[path] = value.place
        if value.data is None and named is not None:
            value = Value({}, value.place)
        if not isinstance(value.data, dict):
            hint = f"its keys are {', '.join(keys_of(cls))}"
            if cls.short and path and isinstance(value.data, str):
                hint = f"write {path[-1]}: {{{cls.short}: {value.data}}}"
            return self._wrong(value.place, f"{name} must be a mapping, not {value.kind}", hint)
        noun, place = (name, named.place) if named is not None else (cls.noun, value.place)
        keys = keys_of(cls)
        self._keys |= {(*path, word): entry.place for word, entry in value.data.items()}
        unknown = self._unknown(cls, value.data, noun)
        found = {
            word: self.read(keys[word].type, entry.value, _At(keys[word], word, (*path, word), _prefix(cls, noun)))
            for word, entry in value.data.items()
            if word in keys
        }
        needed = [word for word, one in keys.items() if one.required]
        for word in needed:
            if word not in found and word not in unknown.values():
                self._missing(keys[word], place, noun)
        is_clear = self._one_of(cls, value, found, unknown, noun) and found.keys() >= {*needed}
        right = {keys[word].field: one for word, one in found.items() if one is not WRONG}
        if not is_clear or any(found[word] is WRONG for word in {*needed, *cls.one_of} & found.keys()):
            return WRONG
        return cls(**right, written=Written(self._places, self._keys, path))

    def _missing(self, key: Key, place: Place, noun: str) -> None:
        what = f"{noun} {key.missing}" if key.missing else f"{noun} needs '{key.name}': {key.doc}"
        self._wrong(place, what, key.hint or f"write {key.name}: {said(key.type)}")

    def _unknown(self, cls: type[Record], data: Mapping[str, Entry], noun: str) -> dict[str, str]:
        """Return the keys that are not declared, each with the one that seems to be meant, or nothing."""
        keys, unknown = keys_of(cls), {}
        for word, entry in data.items():
            if word not in keys:
                near = did_you_mean(word, keys, cls.renamed)
                hint: Hint = near or f"keys are {', '.join(keys)}"
                self.problems.append(Problem(entry.place, f"{noun} has no key '{word}'", hint, "unknown"))
                unknown[word] = near.names[0] if near else ""
        return unknown

    def _one_of(
        self, cls: type[Record], value: Value, found: Mapping[str, Any], unknown: Mapping[str, str], noun: str
    ) -> bool:
        """Return whether exactly one of ``cls.one_of`` is given."""
        given = [word for word in cls.one_of if found.get(word) is not None]
        if len(given) > 1:
            place = value.data[given[1]].place if isinstance(value.data, dict) else value.place
            self._wrong(place, f"{noun} has {' and '.join(map(repr, given))}", "keep one of them")
        elif cls.one_of and not given and not unknown:
            hint = keys_of(cls)[cls.one_of[0]].hint
            self._wrong(value.place, f"{noun} needs one of {', '.join(cls.one_of)}", hint)
        return len(given) == min(len(cls.one_of), 1)

    def read(self, kind: Any, value: Value, at: _At) -> Any:
        """Return what the value of a key says."""
        self._places[at.path] = value.place
        if kind is Value:
            return value
        if is_union(kind):
            return self._member(kind, value, at)
        if is_range(kind):
            return self._range(get_args(kind)[0], value, at)
        if is_record(kind):
            return self.record(kind, value, at.path, f"{at.who}'{at.name}'")
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
            return self.read(members[0], value, at)
        fitting = [member for member in members if fits(member, value)]
        if not fitting:
            return self._not(kind, value, at)
        if isinstance(value.data, dict | list):
            return self.read(fitting[0], value, at)
        param = at.key.as_param(Union[*fitting], at.name)
        if replace(param, ge=None, gt=None, le=None, lt=None).accepts(value.data):
            return self._scalar(param.type, value, at)
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
            what = f"{at.who}the range of '{at.name}' begins with its larger end"
            return self._wrong(value.place, what, f"write [{high:g}, {low:g}]")
        return Range(low, high, at.path)

    def _names(self, kind: Any, value: Value, at: _At) -> Any:
        if not value.data and at.key.min_items and is_mapping(at.key.type) and isinstance(value.data, dict | None):
            return self._wrong(value.place, f"{at.who}'{at.name}' is empty", at.key.hint)
        if not isinstance(value.data, dict):
            return self._not(Mapping[str, kind], value, at)
        self._keys |= {(*at.path, name): entry.place for name, entry in value.data.items()}
        read = {}
        for name, entry in value.data.items():
            self._name(name, entry, at)
            if is_record(kind) and kind.named:
                read[name] = self.record(kind, entry.value, (*at.path, name), kind.named.format(name), entry)
            else:
                read[name] = self.read(kind, entry.value, at.into(name, f"{at.name}.{name}"))
        return {name: one for name, one in read.items() if one is not WRONG}

    def _name(self, name: str, entry: Entry, at: _At) -> None:
        legal = at.key.names
        if legal is not None and legal.what and not re.fullmatch(legal.pattern, name):
            self._wrong(entry.place, f"'{name}' cannot be {legal.what}", legal.hint)

    def _list(self, kind: Any, value: Value, at: _At) -> Any:
        if not isinstance(value.data, list):
            return self._not(kind, value, at)
        if len(value.data) < at.key.min_items:
            has = f"has {len(value.data)} items, but needs at least {at.key.min_items}"
            what = f"{at.who}'{at.name}' {has if value.data else 'is an empty list'}"
            return self._wrong(value.place, what, at.key.hint)
        member = get_args(kind)[0]
        read = [
            self.read(member, item, at.into(str(index), f"{at.name}[{index}]")) for index, item in enumerate(value.data)
        ]
        if is_record(member):
            return tuple(one for one in read if one is not WRONG)
        return WRONG if WRONG in read else tuple(read)

    def _tuple(self, kind: Any, value: Value, at: _At) -> Any:
        positions = positions_of(kind)
        if not isinstance(value.data, list) or len(value.data) != len(positions):
            return self._not(kind, value, at)
        read = [
            self.read(member, item, at.into(name, f"{at.name}.{name}"))
            for item, (name, member) in zip(value.data, positions.items(), strict=True)
        ]
        return WRONG if WRONG in read else kind(*read)

    def _scalar(self, kind: Any, value: Value, at: _At) -> Any:
        if isinstance(value.data, dict | list):
            return self._not(kind, value, at)
        if value.data == "" and at.key.not_empty:
            return self._wrong(value.place, f"{at.who}'{at.name}' is empty", at.key.hint or "write a name")
        param = at.key.as_param(kind, at.name)
        try:
            return param.parse(value.data)
        except ParamError as error:
            hint = error.hint or at.key.hint
            if kind is str and value.data is not None:
                hint = hint or _QUOTES
            elif kind in (int, float) and param.bounds_text and not isinstance(value.data, int | float):
                hint = hint or f"write {param.type_text} {param.bounds_text}"
            return self._wrong(value.place, f"{at.who}{error.what}", hint)

    def _not(self, kind: Any, value: Value, at: _At) -> Any:
        count = f" of {len(value.data)}" if isinstance(value.data, list) else ""
        what = f"{at.who}'{at.name}' must be {said(kind)}, not {value.kind}{count}"
        return self._wrong(value.place, what, at.key.hint)

    def _wrong(self, place: Place, what: str, hint: Hint = "") -> Any:
        self.problems.append(Problem(place, what, hint))
        return WRONG


def _prefix(cls: type[Record], noun: str) -> str:
    return f"{noun}: " if cls.named else ""
