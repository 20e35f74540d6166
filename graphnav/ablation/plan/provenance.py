"""Record what results depend on besides the graph: versions, and hashes of the code of plugins."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from graphnav.ablation.plan.plan import Plan
from graphnav.catalog import GROUP
from graphnav.runner.recording.summary import versions

CODE = "code of "
_HASH_LETTERS = 12


def with_versions(plan: Plan) -> Plan:
    """Return the plan with all that its runs depend on: versions, and the code of its stages."""
    families = {use.partition(".")[0] for case in plan.cases for use in case.uses.values()}
    return replace(plan, versions=provenance(families, plan.plugins))


def provenance(families: Iterable[str], plugins: Iterable[str]) -> dict[str, str]:
    """Return what to compare before runs are put side by side: by name, a version or a hash.

    ``families``: those of the stages, whose packages are hashed; ``plugins``: one-file plugins.
    """
    code = {f"{CODE}{family}": _hash(files) for family in sorted(families) if (files := _files_of(family))}
    return {**versions(), **code, **{plugin: _hash([Path(plugin)]) for plugin in plugins}}


def difference_here(wanted: tuple[tuple[str, str], ...], plugins: tuple[str, ...]) -> str:
    """Return what this process has that is not as ``wanted``, empty if nothing is."""
    families = [name.removeprefix(CODE) for name, _ in wanted if name.startswith(CODE)]
    return difference(dict(wanted), provenance(families, plugins))


def difference(old: Mapping[str, str], new: Mapping[str, str]) -> str:
    """Return the first of what both have that is not the same, empty if nothing is."""
    for name, value in old.items():
        if new.get(name, value) != value:
            return f"another {name}: {value}, now {new[name]}"
    return ""


def _files_of(family: str) -> list[Path]:
    """Return the Python files of the packages of a family."""
    files = []
    for point in entry_points(group=GROUP, name=family):
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
            found.update(hashlib.sha256(file.read_bytes()).digest())
        except OSError as error:
            return str(error.strerror)
    return found.hexdigest()[:_HASH_LETTERS]
