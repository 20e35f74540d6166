"""Make LCM types from the definitions that a log holds, so that it decodes where their packages are not installed.

No program is run: the definitions are parsed here, and a type holds only its layout.
"""

from __future__ import annotations

import functools
import keyword
import re
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from graphnav.core.codec.known_types import add_type, type_named, type_of
from graphnav.core.codec.layout import PRIMITIVES, Dim, fingerprint

_NAME = r"[A-Za-z_][A-Za-z0-9_]*"
_STRUCT = re.compile(
    rf"(?:^package ({_NAME}(?:\.{_NAME})*);\n\n)?^struct ({_NAME})\n\{{\n((?:    .*\n)*)\}}$", re.MULTILINE
)
_MEMBER = re.compile(rf"    ((?:{_NAME}\.)*{_NAME}) ({_NAME})((?:\[(?:{_NAME}|[0-9]{{1,9}})\])*);")
_DIM = re.compile(r"\[(\w+)\]")
_MAX_FIELDS = 10_000
"""How many fields all definitions of a log may have together."""
_MAX_EXPANDED, _MAX_DEPTH = 2000, 32
"""How many fields a type may have with those of all structs in it, and how deep these may be nested: each is walked."""
_MASK = (1 << 64) - 1


class _Member(NamedTuple):
    """A field as it is defined."""

    typename: str
    name: str
    dims: tuple[Dim, ...]


def add_given_types(text: str) -> None:
    """Register the types of definitions, as `lcm_text_of` writes them, unless they are known or cannot be made.

    Definitions are bounded: those after the 10,000th field, and types of more than 2000 fields or 32 levels with the
    structs in them, are left out.
    """
    defined = dict(_structs(text))
    made: dict[str, type | None] = {}
    for name in _bounded(defined):
        lcm_class = _made(name, defined, made)
        if lcm_class is not None and type_of(fingerprint(lcm_class)) is None:
            add_type(name, lcm_class)


def _structs(text: str) -> Iterator[tuple[str, tuple[_Member, ...]]]:
    """Yield the fields of each type by its name; a definition with a line that is not a field is left out."""
    n_fields = 0
    for found in _STRUCT.finditer(text):
        package, short, body = found.groups()
        n_fields += 1 + body.count("\n")
        if n_fields > _MAX_FIELDS:
            return
        members = [_MEMBER.fullmatch(line) for line in body.splitlines()]
        read = tuple(_member(*member.groups()) for member in members if member is not None)
        names = {one.name for one in read}
        is_usable = all(isinstance(dim, int) or dim in names for one in read for dim in one.dims)
        is_usable &= package is not None or short not in PRIMITIVES
        if len(read) == len(members) == len(set(names)) and is_usable and not any(map(keyword.iskeyword, names)):
            yield f"{package}.{short}" if package else short, read


def _member(typename: str, name: str, dims: str) -> _Member:
    return _Member(typename, name, tuple(int(dim) if dim.isdigit() else dim for dim in _DIM.findall(dims)))


def _bounded(defined: Mapping[str, tuple[_Member, ...]]) -> list[str]:
    """Return the names of the types within the bounds; a type that contains itself is not."""
    expanded = dict.fromkeys(defined, 1)
    for _ in range(_MAX_DEPTH):
        before = expanded
        expanded = {
            name: min(_MAX_EXPANDED + 1, 1 + sum(before.get(one.typename, 1) for one in members))
            for name, members in defined.items()
        }
        if expanded == before:
            break
    return [name for name, count in expanded.items() if count <= _MAX_EXPANDED and count == before[name]]


def _made(name: str, defined: Mapping[str, tuple[_Member, ...]], made: dict[str, type | None]) -> type | None:
    """Return a type by its name, None if it is not known; its definition is within the bounds."""
    if name not in defined:
        return type_named(name)
    if name not in made:
        structs = {
            one.typename: _made(one.typename, defined, made) for one in defined[name] if one.typename not in PRIMITIVES
        }
        known = {typename: struct for typename, struct in structs.items() if struct is not None}
        made[name] = _class(name, defined[name], known) if len(known) == len(structs) else None
    return made[name]


def _class(name: str, members: tuple[_Member, ...], structs: Mapping[str, type]) -> type:
    """Return a class with the layout of a type, as `graphnav.core.codec.layout` reads it from those of lcm-gen."""
    package, _, short = name.rpartition(".")
    value = _hash(members, structs)
    made = type(
        short,
        (),
        {
            "__module__": f"{package}.{short}" if package else short,
            "__slots__": (),
            "__typenames__": [one.typename for one in members],
            "__dimensions__": [list(one.dims) or None for one in members],
            "structs": dict(structs),
            "_get_hash_recursive": staticmethod(lambda _: value),
            "_get_packed_fingerprint": staticmethod(lambda: value.to_bytes(8, "big")),
        },
    )
    type.__setattr__(made, "__slots__", [one.name for one in members])
    return made


def _hash(members: tuple[_Member, ...], structs: Mapping[str, Any]) -> int:
    """Return LCM's hash of a type, which is its fingerprint (lcm-gen, ``lcm_struct_hash``)."""
    value = 0x12345678
    for one in members:
        value = _text(value, one.name)
        if one.typename in PRIMITIVES:
            value = _text(value, one.typename)
        value = _update(value, len(one.dims))
        for dim in one.dims:
            value = _text(_update(value, isinstance(dim, str)), str(dim))
    nested = (structs[one.typename] for one in members if one.typename not in PRIMITIVES)
    value = (value + sum(int(struct._get_hash_recursive([])) for struct in nested)) & _MASK  # noqa: SLF001
    return (value << 1 | value >> 63) & _MASK


def _text(value: int, text: str) -> int:
    return functools.reduce(_update, text.encode(), _update(value, len(text)))


def _update(value: int, number: int) -> int:
    """Add a number to a hash of 64 bits with a sign."""
    signed = value - (1 << 64) if value >> 63 else value
    return (((signed << 8) ^ (signed >> 55)) + number) & _MASK
