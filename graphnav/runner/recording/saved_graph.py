"""Save the graph of a run in its folder so that it runs again: resolved, with a copy of its one-file plugins."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from graphnav.errors import UserError
from graphnav.graph import Graph, resolved_yaml
from graphnav.run_folder import GRAPH

PLUGINS = "plugins"
"""The folder of the plugins' copies, below that of the run."""


def save_graph(graph: Graph, folder: Path) -> None:
    """Write ``graph.yaml``, which runs again from any folder, and the plugins that it needs into a run folder.

    Raises
    ------
    UserError
        The folder cannot be written, or a plugin can no longer be read.
    """
    names = _unique_names(graph.plugins)
    for path, name in zip(graph.plugins, names, strict=True):
        _write(folder / name, _read(path), folder)
    text = resolved_yaml(graph, portable_paths=False, plugins=names)
    _write(folder / GRAPH, text.encode(), folder)


def _unique_names(paths: Sequence[Path]) -> list[str]:
    """Return the path of each saved plugin. File names are kept: they may be the names of families."""
    names: list[str] = []
    for path in paths:
        name, number = f"{PLUGINS}/{path.name}", 1
        while name in names:
            number += 1
            name = f"{PLUGINS}/{number}/{path.name}"
        names.append(name)
    return names


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UserError.of(f"plugin {path} cannot be saved with the run: {error.strerror}") from error


def _write(path: Path, data: bytes, folder: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    except OSError as error:
        raise UserError.of(f"cannot write into {folder}: {error.strerror}", "choose another folder with -o") from error
