"""The reference page of a kind of file, in Markdown: every key, with type, unit, bounds and meaning."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from typing import Any, get_args

from graphnav.core.spec.declared.kinds import is_list, is_mapping, is_range, is_record, is_union, positions_of, said
from graphnav.core.spec.declared.record import Key, Record, keys_of
from graphnav.core.spec.write import write_value
from graphnav.core.stage import unit_of
from graphnav.core.tables import Cell, Table


def reference_page(root: type[Record], title: str, doc: str) -> str:
    """Return the page of files whose root is a record; ``doc`` comes first."""
    parts = [f"# {title}", inspect.cleandoc(doc), *(part for cls in _records(root) for part in _section(cls))]
    return "\n\n".join(parts) + "\n"


def _records(cls: Any, found: dict[type[Record], None] | None = None) -> dict[type[Record], None]:
    """Return a record and all that are in it, in the order of their keys."""
    found = {} if found is None else found
    if is_record(cls) and cls not in found:
        found[cls] = None
        for key in keys_of(cls).values():
            _records(key.type, found)
    for member in () if is_record(cls) else (*get_args(cls), *positions_of(cls).values()):
        _records(member, found)
    return found


def _section(cls: type[Record]) -> Iterator[str]:
    yield f"## {_heading(cls)}"
    yield inspect.getdoc(cls) or ""
    if cls.one_of:
        yield f"Exactly one of {_listed([f'`{name}`' for name in cls.one_of])} is given."
    rows = [_row(key, name in cls.one_of) for name, key in keys_of(cls).items()]
    yield Table.plain(("key", "value", "unit", "default", "meaning"), rows).markdown()
    if cls.example:
        yield f"```yaml\n{inspect.cleandoc(cls.example)}\n```"


def _row(key: Key, is_choice: bool) -> list[Cell]:  # noqa: FBT001 - of a table
    bounds = key.as_param(float, key.name).bounds_text
    items = "" if not key.min_items else "not empty" if key.min_items == 1 else f"at least {key.min_items} items"
    value = ", ".join(filter(None, (_linked(key.type), bounds, items)))
    default = "" if key.plain_default is None else f"`{write_value(key.plain_default)}`"
    needed = "one of them" if is_choice else "required" if key.required else default
    cells = (f"`{key.name}`", value, unit_of(key.name).words, needed, key.doc)
    return [Cell(text, is_markdown=True) for text in cells]


def _linked(kind: Any) -> str:
    """Return a type in words, in which records are links to their sections."""
    if is_union(kind):
        *others, last = dict.fromkeys(_linked(member) for member in get_args(kind) if member is not type(None))
        return f"{', '.join(others)} or {last}" if others else last
    if is_record(kind):
        return f"[{kind.noun}](#{_heading(kind).lower().replace(' ', '-')})"
    if is_range(kind):
        return f"{said(get_args(kind)[0])} or a range"
    if (is_list(kind) or is_mapping(kind)) and len(_records(kind)) > 0:
        each = get_args(kind)[0] if is_list(kind) else get_args(kind)[1]
        return f"{said(kind)}, each {_linked(each)}" if is_list(kind) else f"names, each with {_linked(each)}"
    return said(kind)


def _heading(cls: type[Record]) -> str:
    return cls.noun[:1].upper() + cls.noun[1:]


def _listed(words: list[str]) -> str:
    return f"{', '.join(words[:-1])} and {words[-1]}"
