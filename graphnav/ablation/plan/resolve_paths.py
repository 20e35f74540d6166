"""Resolve the paths that a study names: first those beside its file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from graphnav.ablation.study import targets_of
from graphnav.errors import Place, UserError
from graphnav.graph import Graph
from graphnav.graph.overrides.assignment import Assignment
from graphnav.graph.paths import has_path
from graphnav.spec import write_value
from graphnav.stage import params_of


def resolve_paths(graph: Graph, text: str, folder: Path) -> str:
    """Return a ``--set`` text whose paths are absolute where they are in ``folder``, the study's; else as it is."""
    nodes = {node.name: node for node in graph.nodes}
    may_be_path = any(
        stage in nodes and key in (declared := params_of(nodes[stage].stage_class)) and has_path(declared[key].type)
        for stage, key in targets_of(text)
    )
    if not may_be_path:
        return text
    target, _, value = text.partition("=")
    try:
        plain = Assignment("param", "", target, value, Place("")).entry.value.plain()
    except UserError:
        return text
    moved = _moved(plain, folder)
    return text if moved == plain else f"{target}={write_value(moved)}"


def _moved(value: Any, folder: Path) -> Any:
    if isinstance(value, list):
        return [_moved(item, folder) for item in value]
    return str(folder / value) if isinstance(value, str) and _is_in(folder, value) else value


def _is_in(folder: Path, path: str) -> bool:
    """Return whether there is such a file, or one that a pattern (``*.jpg``) matches."""
    try:
        return (folder / path).exists() or any(folder.glob(path))
    except (OSError, ValueError, NotImplementedError):  # too long, with a null character, or absolute
        return False
