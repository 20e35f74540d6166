"""Properties that runs depend on beside their graph: versions, and the code of the stages."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from importlib.metadata import EntryPoint, entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from graphnav.core.catalog import GROUP, family_of
from graphnav.core.graph import Graph
from graphnav.core.machine.instruction_set import PORTABLE
from graphnav.core.machine.pins import OPT_OUT
from graphnav.core.runner.recording.summary import Summary

CODE = "code of "
FILE = "file "
_HASH_LETTERS = 12
_MAX_HASHED_BYTES = 64 * 1024**2
"""Of a file; of a longer one, such as a video, the beginning and the length are hashed."""


class Difference(NamedTuple):
    """A property that two sets of runs depend on and that differs: its name and both values."""

    name: str
    old: str
    new: str

    def __str__(self) -> str:
        return f"another {self.name}: {self.old}, now {self.new}"

    @property
    def hint(self) -> str:
        """How to make both the same, empty where that depends."""
        if self.name != Summary.INSTRUCTION_SET:
            return ""
        if self.old == PORTABLE:
            return f"run without --no-portable, and without {OPT_OUT}=0 in the environment"
        return "use another folder, without --no-portable: then all machines with AVX2 and FMA make the same runs"


def provenance(families: Iterable[str], plugins: Iterable[str]) -> dict[str, str]:
    """Return what to compare before runs are put side by side: by name, a version or a hash.

    ``families``: those of the stages, whose packages are hashed; ``plugins``: one-file plugins.
    """
    points = sorted(entry_points(group=GROUP), key=lambda point: point.name)
    code = {f"{CODE}{family}": _hash(files) for family in sorted(families) if (files := _files_of(family, points))}
    return {**Summary.versions_here(), **code, **{plugin: _hash([Path(plugin)]) for plugin in plugins}}


def files_of_graphs(graphs: Iterable[Graph]) -> dict[str, str]:
    """Return hashes of the files that parameters of the stages name: networks, models, maps; by what they write.

    Files of several graphs that are written alike have one hash together.
    """
    named: dict[str, set[Path]] = {}
    for graph in graphs:
        for setting in (setting for node in graph.nodes for setting in node.settings.values()):
            if isinstance(setting.value, Path) and setting.value.is_file():
                named.setdefault(f"{FILE}{setting.written}", set()).add(setting.value)
    return {name: _hash(sorted(paths)) for name, paths in sorted(named.items())}


def difference_here(wanted: Mapping[str, str], plugins: Iterable[str]) -> Difference | None:
    """Return what this process has that is not as ``wanted``, None if nothing is."""
    families = [name.removeprefix(CODE) for name in wanted if name.startswith(CODE)]
    return difference(wanted, provenance(families, plugins))


def difference(old: Mapping[str, str], new: Mapping[str, str]) -> Difference | None:
    """Return the first of what both have that is not the same, None if nothing is."""
    changed = (name for name, value in old.items() if new.get(name, value) != value)
    return next((Difference(name, old[name], new[name]) for name in changed), None)


def _files_of(family: str, points: Iterable[EntryPoint]) -> list[Path]:
    """Return the Python files of the packages of a family; ``points``: all entry points of graphnav."""
    files = []
    for point in points:
        if family_of(point) != family:
            continue
        spec = find_spec(point.module.partition(".")[0])
        if spec is not None and spec.submodule_search_locations:
            files += [file for folder in spec.submodule_search_locations for file in sorted(Path(folder).rglob("*.py"))]
        elif spec is not None and spec.origin:
            files.append(Path(spec.origin))
    return files


def _hash(files: Iterable[Path]) -> str:
    found = hashlib.sha256()
    for file in files:
        try:
            with file.open("rb") as opened:
                found.update(hashlib.sha256(opened.read(_MAX_HASHED_BYTES)).digest())
                if opened.read(1):
                    found.update(str(file.stat().st_size).encode())
        except OSError as error:
            return str(error.strerror)
    return found.hexdigest()[:_HASH_LETTERS]
