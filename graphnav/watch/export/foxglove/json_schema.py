"""Scalars as JSON, with a schema that makes them available to Foxglove's plots."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from graphnav.core.codec import fields_of, lcm_name
from graphnav.watch.export.tables.scalar_fields import has_few_elements

_TYPES = {"float": "number", "double": "number", "boolean": "boolean", "string": "string"}


def schema_of(lcm_class: type) -> dict[str, Any]:
    """Return the JSON schema of the scalars of an LCM type: including nested structs and small fixed arrays."""
    properties: dict[str, Any] = {}
    fields = fields_of(lcm_class)
    sizes = {dim for field in fields for dim in field.dims}
    for field in fields:
        if field.name in sizes or not has_few_elements(field):
            continue
        part = {"type": _TYPES.get(field.primitive, "integer")} if field.struct is None else schema_of(field.struct)
        for _ in field.dims:
            part = {"type": "array", "items": part}
        properties[field.name] = part
    return {"title": lcm_name(lcm_class), "type": "object", "properties": properties}


def values_of(schema: dict[str, Any], value: Any) -> Any:
    """Return decoded LCM fields as JSON-compatible values; non-finite numbers are left out, in arrays null."""
    if "properties" in schema:
        parts = {name: values_of(part, value[name]) for name, part in schema["properties"].items()}
        return {name: part for name, part in parts.items() if part is not None}
    if "items" in schema:
        return [values_of(schema["items"], element) for element in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
