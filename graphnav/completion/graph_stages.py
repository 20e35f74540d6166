"""The stages of a graph that a command line names, without loading it."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from typing import Any

from graphnav.completion.index import Index
from graphnav.errors import GraphnavError


def stages_of(names: Iterable[str], index: Index) -> dict[str, str]:
    """Return the class of each stage of some graphs and studies; of a file what it and the graphs it extends say.

    No plugin is imported: TAB runs nothing that a graph names.
    """
    uses: dict[str, str] = {}
    for name in names:
        if name in index.studies:
            uses |= stages_of(index.studies[name], index)
        elif name in index.graphs:
            uses |= index.graphs[name]
        else:
            with suppress(GraphnavError):
                uses |= _stages_of_file(name)
    return uses


def _stages_of_file(name: str) -> dict[str, str]:
    from graphnav.errors import Place
    from graphnav.graph import find_graph
    from graphnav.graph.read.graph_files import read_files
    from graphnav.spec import read_bytes

    path = find_graph(name)
    uses: dict[str, str] = {}
    for file in read_files(read_bytes(path, Place(name)), path, name, []):
        _update(uses, file.value.plain())
    return uses


def _update(uses: dict[str, str], words: Any) -> None:
    """Add the stages of a file and remove those that it sets to null."""
    stages = words.get("stages") if isinstance(words, dict) else None
    for name, stage in stages.items() if isinstance(stages, dict) else ():
        if stage is None:
            uses.pop(name, None)
        elif isinstance(stage, dict) and isinstance(stage.get("use"), str):
            uses[name] = stage["use"]
