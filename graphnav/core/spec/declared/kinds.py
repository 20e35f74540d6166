"""The types that keys of records may have: what they are in YAML, and what messages and pages call them."""

from __future__ import annotations

import types
from collections.abc import Mapping
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

from graphnav.core.spec.declared.record import Range, Record
from graphnav.core.spec.value import Value
from graphnav.core.stage.param import type_text


def is_record(kind: Any) -> bool:
    """Return whether a type is a record."""
    return isinstance(kind, type) and issubclass(kind, Record)


def is_union(kind: Any) -> bool:
    """Return whether a type is one of several."""
    return get_origin(kind) in (Union, types.UnionType)


def is_mapping(kind: Any) -> bool:
    """Return whether a type is a mapping with free names."""
    return get_origin(kind) is Mapping


def is_range(kind: Any) -> bool:
    """Return whether a type is a number that may be drawn."""
    return get_origin(kind) is Range


def is_list(kind: Any) -> bool:
    """Return whether a type is a list of any length."""
    return get_origin(kind) is tuple and get_args(kind)[-1] is Ellipsis


@cache
def positions_of(kind: Any) -> Mapping[str, Any]:
    """Return the type of each position of a NamedTuple, by name; nothing for other types."""
    is_named = isinstance(kind, type) and issubclass(kind, tuple) and hasattr(kind, "_fields")
    return get_type_hints(kind) if is_named else {}


def fits(kind: Any, value: Value) -> bool:
    """Return whether a value is of the kind of YAML (mapping, list, scalar, null) that a type is read from."""
    if kind is Value:
        return True
    if kind is type(None):
        return value.data is None
    if is_record(kind) or is_mapping(kind):
        return isinstance(value.data, dict)
    if is_list(kind) or positions_of(kind):
        return isinstance(value.data, list)
    return value.data is not None and not isinstance(value.data, dict if is_range(kind) else dict | list)


def said(kind: Any) -> str:
    """Return a type as messages and pages say it: ``a number or a range [low, high]``."""
    if is_union(kind):
        *others, last = dict.fromkeys(said(member) for member in get_args(kind) if member is not type(None))
        return f"{', '.join(others)} or {last}" if others else last
    if kind is Value:
        return "any value"
    if is_record(kind) or is_mapping(kind):
        return "a mapping"
    if is_range(kind):
        return f"{type_text(get_args(kind)[0])} or a range [low, high]"
    if is_list(kind):
        return "a list"
    return f"[{', '.join(positions_of(kind))}]" if positions_of(kind) else type_text(kind)
