"""``plugins:`` of a graph: one-file plugins, loaded before anything else of it is checked."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from graphnav.catalog import Catalog
from graphnav.errors import CatalogError, Problem
from graphnav.graph.read.graph_files import GraphFile
from graphnav.spec import Value

_HINT = "write plugins: [my_stage.py]"


@dataclass(frozen=True)
class PluginFile:
    """A one-file plugin that a graph names."""

    path: Path
    """Absolute."""
    written: str
    """As the graph names it."""


def load_plugins(
    files: Sequence[GraphFile], catalog: Catalog, problems: list[Problem], replaced: Collection[str] = ()
) -> tuple[PluginFile, ...]:
    """Add the plugins of a graph's files to the catalog and return them, each once; what is wrong goes to ``problems``.

    A path is relative to the folder of the file that it is written in. Files with a name in ``replaced`` are left out.
    """
    found: dict[Path, PluginFile] = {}
    for file in files:
        for item in _items(file.value, problems):
            path = file.path.parent / os.path.expanduser(str(item.data))
            if path.name in replaced:
                continue
            try:
                catalog.add_file(path)
            except CatalogError as error:
                problems.append(Problem(item.place, error.what, error.hint))
            else:
                found.setdefault(path.resolve(), PluginFile(path.resolve(), str(item.data)))
    return tuple(found.values())


def _items(value: Value, problems: list[Problem]) -> Iterator[Value]:
    """Yield the paths under ``plugins``."""
    entry = value.data.get("plugins") if isinstance(value.data, dict) else None
    if entry is None or entry.value.data is None:
        return
    if not isinstance(entry.value.data, list):
        problems.append(Problem(entry.value.place, f"'plugins' must be a list, not {entry.value.kind}", _HINT))
        return
    for item in entry.value.data:
        if isinstance(item.data, str) and item.data:
            yield item
        else:
            problems.append(Problem(item.place, f"'plugins' must list files, but this is {item.kind}", _HINT))
