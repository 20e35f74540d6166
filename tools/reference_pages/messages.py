"""The page of the messages: every LCM type with its fields, units and signs."""

from __future__ import annotations

from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.codec import lcm_name, message_classes
from graphnav.core.typeinfo import describe_type, nested_types
from reference_pages.markdown import bullets, code, docstring, page, sentence

_INTRO = """\
What stages exchange. Each message is a frozen dataclass in Python and an LCM type on the wire, of the package
`graphnav_lcm` unless its name says otherwise. `graphnav types NAME` prints the same, and `graphnav types NAME
--lcm` the definition that `lcm-gen` turns into C, C++, Java, Go, Lua or C#.

Conventions: names end in their unit; `utime` is the stamp in microseconds and `seq` counts the messages of a
channel; both are filled by the runner and are not fields in Python. Images and grids are row-major, rows down,
columns right. The robot's frame R has x forward and y left; W is the world. Angles and turning rates are positive
counterclockwise."""


def messages_page() -> str:
    """Return the page."""
    catalog = Catalog()
    for family in catalog.families():
        catalog.load(family)
    shipped = (message for message in message_classes() if message.__module__.startswith("graphnav"))
    ours = sorted((message.lcm_class for message in shipped), key=_title)
    nested = {lcm_name(one): one for lcm_class in ours for one in nested_types(lcm_class)}
    read = [adapter.lcm_class for _, adapter in sorted(catalog.adapters().readers.items())]
    adapted = {lcm_name(one): one for lcm_class in read for one in (lcm_class, *nested_types(lcm_class))}
    parts = ["## Parts of messages", "Types that other types contain.", *map(_section, nested.values())]
    other = [
        "## Types of other packages",
        "Read and written by the adapters that ship.",
        *map(_section, adapted.values()),
    ]
    return page("Messages", _INTRO, "## Messages", *map(_section, ours), *parts, *other)


def _title(lcm_class: type) -> str:
    said = describe_type(lcm_class)
    return str(said["message"] or said["type"])


def _section(lcm_class: type) -> str:
    said = describe_type(lcm_class)
    kind = f"LCM type `{said['type']}`" if said["message"] else ""
    lines = [_field(field, said["type"]) for field in said["fields"]]
    lines += [f"constant `{name}` = {value}" for name, value in said["constants"].items()]
    parts = (f"### {_title(lcm_class)}", kind, docstring(said["doc"]), bullets(lines))
    return "\n\n".join(part for part in parts if part)


def _field(field: dict[str, Any], owner: str) -> str:
    kind = field["type"].removeprefix(f"{owner.rpartition('.')[0]}.")
    shape = "".join(f"[{size}]" for size in field["dims"])
    said = f"`{field['name']}` ({sentence(code(kind + shape), field['unit'])})"
    return f"{said}: {docstring(field['doc'])}" if field["doc"] else said
