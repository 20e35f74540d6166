"""The JSON Schema (draft 2020-12) of declared records, and of parameters."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

from graphnav.core.spec.declared.kinds import is_list, is_mapping, is_range, is_record, is_union, positions_of
from graphnav.core.spec.declared.record import Key, Record, keys_of
from graphnav.core.spec.value import Value
from graphnav.core.stage import Param, plain_data

Schema = dict[str, Any]

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_SCALARS: Mapping[Any, str] = {bool: "boolean", int: "integer", float: "number", str: "string"}
_BOUNDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}


def record_schema(cls: type[Record], title: str) -> Schema:
    """Return the schema of files whose root is a record: what it refuses is wrong, but not all that is wrong."""
    found: dict[str, Schema] = {}
    root = _reference(cls, found)
    return {"$schema": DIALECT, "title": title, **root, "$defs": found}


def param_schema(param: Param) -> Schema:
    """Return the schema of a parameter."""
    bounds = {name: getattr(param, name) for name in _BOUNDS}
    return _described(_type(param.type, {}), bounds, param.doc, () if param.required else (param.default,))


def object_schema(properties: Schema, required: Iterable[str] = ()) -> Schema:
    """Return the schema of a mapping with no other keys than ``properties``."""
    schema: Schema = {"type": "object", "properties": properties, "additionalProperties": False}
    return {**schema, "required": [*required]} if required else schema


def record_object(cls: type[Record], found: dict[str, Schema]) -> Schema:
    """Return the schema of a record by itself; those of the records in it are added to ``found``, by name."""
    keys = keys_of(cls)
    words = {name: _key(one, found) for name, one in keys.items()}
    schema = object_schema(words, [name for name, one in keys.items() if one.required])
    schema["description"] = " ".join((inspect.getdoc(cls) or "").partition("\n\n")[0].split())
    if cls.one_of:
        given = {"not": {"type": "null"}}
        schema["oneOf"] = [{"required": [name], "properties": {name: given}} for name in cls.one_of]
    return {**schema, **cls.conditions}


def _reference(cls: type[Record], found: dict[str, Schema]) -> Schema:
    """Return a reference to the schema of a record, which is added to ``found``."""
    if cls.__name__ not in found:
        found[cls.__name__] = {}
        found[cls.__name__] = record_object(cls, found)
    return {"$ref": f"#/$defs/{cls.__name__}"}


def _key(key: Key, found: dict[str, Schema]) -> Schema:
    schema = _type(key.type, found)
    if key.min_items:
        _set(schema, "array", {"minItems": key.min_items})
    if key.min_items and is_mapping(key.type):
        schema["minProperties"] = key.min_items
    if key.not_empty:
        _set(schema, "string", {"minLength": 1})
    if key.pattern:
        _set(schema, "string", {"pattern": f"^{key.pattern}$"})
    if key.names:
        _set(schema, "object", {"propertyNames": {"pattern": f"^{key.names.pattern}$"}})
    return _described(schema, key.bounds, key.doc, () if key.plain_default is None else (key.plain_default,))


def _described(schema: Schema, bounds: Mapping[str, float | None], doc: str, default: tuple[Any, ...]) -> Schema:
    given = {_BOUNDS[name]: bound for name, bound in bounds.items() if bound is not None}
    for kind in ("integer", "number"):
        _set(schema, kind, given)
    described = {**schema, "description": doc}
    return {**described, "default": plain_data(default[0])} if default else described


def _set(schema: Schema, kind: str, words: Mapping[str, Any]) -> None:
    """Add words to every part of a schema that is of a type."""
    if schema.get("type") == kind and "prefixItems" not in schema:
        schema.update(words)
    inner = [schema[word] for word in ("items", "additionalProperties") if isinstance(schema.get(word), dict)]
    for member in [*schema.get("anyOf", ()), *schema.get("prefixItems", ()), *inner]:
        _set(member, kind, words)


def _type(kind: Any, found: dict[str, Schema]) -> Schema:
    origin, args = get_origin(kind), get_args(kind)
    if kind is Value:
        return {}
    if is_record(kind):
        return _reference(kind, found)
    if is_mapping(kind):
        return {"type": "object", "additionalProperties": _type(args[1], found)}
    if is_range(kind):
        ends = [_type(args[0], found) for _ in range(2)]
        return {"anyOf": [_type(args[0], found), _tuple(ends)]}
    if is_list(kind):
        return {"type": "array", "items": _type(args[0], found)}
    if origin is tuple or positions_of(kind):
        return _tuple([_type(member, found) for member in (args or positions_of(kind).values())])
    if is_union(kind):
        return {"anyOf": [{"type": "null"} if member is type(None) else _type(member, found) for member in args]}
    return _scalar(kind)


def _scalar(kind: Any) -> Schema:
    if get_origin(kind) is Literal:
        return {"enum": list(get_args(kind))}
    if kind is Path:
        return {"type": ["string", "integer"], "minLength": 1, "minimum": 0}
    return {"type": _SCALARS[kind]}


def _tuple(members: list[Schema]) -> Schema:
    return {"type": "array", "prefixItems": members, "minItems": len(members), "maxItems": len(members)}
