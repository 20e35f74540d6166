"""Save the graph of a run in its folder so that it runs again: resolved, with a copy of its one-file plugins."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from graphnav.core.errors import UserError
from graphnav.core.graph import Graph, resolved_yaml
from graphnav.core.run_folder import RunFolder
from graphnav.core.trust import remember_written


def save_graph(graph: Graph, folder: Path) -> None:
    """Write ``graph.yaml``, which runs again from any folder, and the plugins that it needs into a run folder.

    The plugins are remembered as written by this user, so that what reads the folder may run them: see
    `graphnav.core.trust`.

    Raises
    ------
    UserError
        The folder cannot be written, or a plugin can no longer be read.
    """
    copies = copies_of(graph.plugins)
    for name, data in copies.items():
        _write(folder / name, data, folder)
    text = resolved_yaml(graph, portable_paths=False, plugins=list(copies))
    _write(folder / RunFolder.GRAPH, text.encode(), folder)
    if copies:
        remember_written(copies)


def remember_copies(plugins: Sequence[Path]) -> None:
    """Remember the copies that runs save of their plugins as written by this user, wherever they are made.

    Raises
    ------
    UserError
        A plugin can no longer be read.
    """
    remember_written(copies_of(plugins))


def copies_of(plugins: Sequence[Path]) -> dict[str, bytes]:
    """Return the content of each saved plugin by its path in the run folder.

    Raises
    ------
    UserError
        A plugin can no longer be read.
    """
    return {name: _read(path) for name, path in zip(_unique_names(plugins), plugins, strict=True)}


def _unique_names(paths: Sequence[Path]) -> list[str]:
    """Return the path of each saved plugin. File names are kept: they may be the names of families."""
    names: list[str] = []
    for path in paths:
        name, number = f"{RunFolder.PLUGINS}/{path.name}", 1
        while name in names:
            number += 1
            name = f"{RunFolder.PLUGINS}/{number}/{path.name}"
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
