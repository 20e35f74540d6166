"""Definitions of LCM types in LCM's definition language."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from pathlib import Path

from graphnav.core.codec import definition_of, lcm_name
from graphnav.core.typeinfo.describe import nested_types


def definition_files(lcm_classes: Iterable[type]) -> dict[str, str]:
    """Return the ``.lcm`` files of types and of all that are nested in them: file name and text, sorted by name.

    The text is that of the ``.lcm`` file next to the generated Python, as shipped by graphnav; without such a file it
    is generated from the fields, without comments and constants, which do not affect messages.
    """
    found: dict[str, type] = {}
    for lcm_class in lcm_classes:
        found |= {f"{lcm_name(one)}.lcm": one for one in (lcm_class, *nested_types(lcm_class))}
    return {name: _text(found[name]) for name in sorted(found)}


def definition_text(lcm_classes: Iterable[type]) -> str:
    """Return the definitions of types and of all that are nested in them, as one file for lcm-gen."""
    return "\n".join(definition_files(lcm_classes).values())


def _text(lcm_class: type) -> str:
    file = Path(inspect.getfile(lcm_class)).with_suffix(".lcm")
    if file.is_file():
        return file.read_text(encoding="utf-8")
    return definition_of(lcm_class)
