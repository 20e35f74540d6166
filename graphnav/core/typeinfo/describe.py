"""Describe an LCM type from its definition, its field names and its message class."""

from __future__ import annotations

import inspect
from typing import Any

from graphnav.core.codec import comments_of, constants_of, fields_of, fingerprint, lcm_name, message_class_of
from graphnav.core.stage import unit_of

"""Units of durations and memory, which occur in messages but not in parameters."""


def describe_type(lcm_class: type, name: str = "") -> dict[str, Any]:
    """Return the description of a type as JSON-compatible values.

    ``name``: the LCM name if the Python package has another name. The unit of a field is given by its suffix; ``doc``
    is the comment above it.
    """
    message = message_class_of(lcm_class)
    comments = comments_of(lcm_class)
    return {
        "type": name or lcm_name(lcm_class),
        "message": message.__name__ if message else None,
        "doc": inspect.getdoc(message or lcm_class) or "",
        "fingerprint": fingerprint(lcm_class).hex(),
        "constants": constants_of(lcm_class),
        "fields": [
            {
                "name": field.name,
                "type": field.primitive,
                "dims": list(field.dims),
                "unit": "microseconds" if field.name == "utime" else unit_of(field.name).words,
                "doc": comments.get(field.name, ""),
            }
            for field in fields_of(lcm_class)
        ],
        "nested": [lcm_name(nested) for nested in nested_types(lcm_class)],
    }


def nested_types(lcm_class: type) -> list[type]:
    """Return the types of a type's fields, recursively, each once."""
    found: list[type] = []
    waiting = [field.struct for field in fields_of(lcm_class) if field.struct is not None]
    while waiting:
        nested = waiting.pop(0)
        if nested not in found and nested is not lcm_class:
            found.append(nested)
            waiting += [field.struct for field in fields_of(nested) if field.struct is not None]
    return found


def summary_of_type(lcm_class: type) -> str:
    """Return the first line of a type's description."""
    return (inspect.getdoc(message_class_of(lcm_class) or lcm_class) or "").partition("\n")[0]
