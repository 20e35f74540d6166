"""Describe LCM types: a summary, nested types, definitions in LCM's definition language."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from graphnav.core.codec import (
    comments_of,
    constants_of,
    definition_of,
    fields_of,
    fingerprint,
    lcm_name,
    message_class_of,
)
from graphnav.core.stage import unit_of


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


def definition_files(lcm_classes: Iterable[type]) -> dict[str, str]:
    """Return the ``.lcm`` files of types and of all that are nested in them: file name and text, sorted by name.

    The text is that of the ``.lcm`` file next to the generated Python, as shipped by graphnav; without such a file it
    is generated from the fields, without comments and constants, which do not affect messages.
    """
    found: dict[str, type] = {}
    for lcm_class in lcm_classes:
        found |= {f"{lcm_name(one)}.lcm": one for one in (lcm_class, *nested_types(lcm_class))}
    return {name: _text(found[name]) for name in sorted(found)}


def _text(lcm_class: type) -> str:
    file = Path(inspect.getfile(lcm_class)).with_suffix(".lcm")
    if file.is_file():
        return file.read_text(encoding="utf-8")
    return definition_of(lcm_class)
