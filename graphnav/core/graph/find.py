"""Find a graph: a file, or the name of one in the working folder or among those that ship."""

from __future__ import annotations

import importlib.resources
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from graphnav.core.errors import Hint, Place, Suggestion, UserError, did_you_mean

SHIPPED = "graphnav_graphs"
"""The data package with graphs, maps and planar models."""

_SUFFIXES = (".yaml", ".yml")
_STUDIES = "studies"
_PARTS = "parts"
"""The folder of the data package with files that are not graphs by themselves: graphs extend them."""
_NO_GRAPHS = ("maps", _PARTS, _STUDIES)
"""Folders of the data package whose YAML files are no graphs."""


@cache
def shipped_folder() -> Path:
    """Return the folder of the data that ships."""
    return Path(str(importlib.resources.files(SHIPPED)))


@cache
def shipped_graphs() -> Mapping[str, Path]:
    """Return the graphs that ship, by name: that of a graph in a folder is ``folder/name``."""
    folder = shipped_folder()
    in_folders = (path for path in sorted(folder.glob("*/*.yaml")) if path.parent.name not in _NO_GRAPHS)
    paths = (*sorted(folder.glob("*.yaml")), *in_folders)
    return {path.relative_to(folder).with_suffix("").as_posix(): path for path in paths}


@cache
def shipped_parts() -> Mapping[str, Path]:
    """Return the parts of graphs that ship, by name: ``parts/name``."""
    folder = shipped_folder()
    return {f"{_PARTS}/{path.stem}": path for path in sorted((folder / _PARTS).glob("*.yaml"))}


def find_graph(name: str | Path, folder: Path = Path()) -> Path:
    """Return the file of a graph, or of a part that graphs extend; ``folder`` is what a relative path begins at.

    Raises
    ------
    UserError
        There is none.
    """
    path = folder / name
    candidates = [path] if path.suffix in _SUFFIXES else [path, *(Path(f"{path}{suffix}") for suffix in _SUFFIXES)]
    for candidate in candidates:
        if _exists(candidate) and not candidate.is_dir():
            return candidate
    shipped = {**shipped_graphs(), **shipped_parts()}
    if str(name) in shipped:
        return shipped[str(name)]
    if _exists(path) and path.is_dir():
        near = sorted(p.name for p in path.glob("*.yaml"))
        files = f"name a file in it: {', '.join(near[:5])}" if near else "name a YAML file"
        raise UserError.of("it is a folder, not a graph", files, Place(str(name)))
    beside = path.parent if _exists(path.parent) else Path()
    known = {*shipped, *(_from(folder, p) for suffix in _SUFFIXES for p in beside.glob(f"*{suffix}"))}
    hint: Hint = (
        _if_study(str(name)) or suggest_graph(str(name), known) or f"graphs that ship: {', '.join(shipped_graphs())}"
    )
    raise UserError.of("there is no such graph", hint, Place(str(name)))


def suggest_graph(name: str, known: Iterable[str]) -> Suggestion:
    """Return the hint for an unknown graph: one of that name in a folder, else the nearest name; false if neither."""
    names = sorted(known)
    in_folders = {one.rpartition("/")[2]: one for one in names if "/" in one}
    if name in in_folders:
        return Suggestion((in_folders[name],), f"did you mean '{in_folders[name]}'?")
    return did_you_mean(name, names)


def _if_study(name: str) -> str:
    """Return the hint for the name of a study."""
    studies = {path.stem for path in (shipped_folder() / _STUDIES).glob("*.yaml")}
    return f"it is a study; run it with 'graphnav ablate {name}'" if name in studies else ""


def _from(folder: Path, path: Path) -> str:
    """Return a path as it is written in ``folder``."""
    return str(path.relative_to(folder) if path.is_relative_to(folder) else path)


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long, or with a null character
        return False
