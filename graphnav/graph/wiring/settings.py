"""Parameters: what a graph gives, checked against what a stage declares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from graphnav.errors import ParamError, Place, Problem, did_you_mean
from graphnav.graph.node import Setting
from graphnav.graph.paths import has_path, resolve_paths
from graphnav.spec import Entry, RunOptions, StageSpec, check_url
from graphnav.stage import Param, Stage, params_of

SET = "--set"
"""Places of what the command line gives begin so."""


def is_from_set(place: Place) -> bool:
    """Return whether something was given by ``--set``, not in the file."""
    return place.file.startswith(SET)


def settings_of(
    spec: StageSpec,
    cls: type[Stage],
    folder: Path,
    problems: list[Problem],
    folders: Mapping[str, Path] = MappingProxyType({}),
) -> dict[str, Setting]:
    """Return every parameter of a stage with its value; what is wrong is added to ``problems``.

    ``folder`` is the graph's own: paths resolve against it, those of ``--set`` against the working folder, those of a
    file that the graph extends against that of ``folders``, by the file's name in places.
    """
    declared = params_of(cls)
    problems += _unknown(spec.params, declared, f"{spec.use} has no parameter")
    settings = {}
    for name, param in declared.items():
        entry = spec.params.get(name)
        if entry is None and param.required:
            if (
                spec.unclear
                or param.renamed_from in spec.params
                or any(did_you_mean(word, declared) == did_you_mean(name, [name]) for word in spec.params)
            ):
                continue
            what = f"stage '{spec.name}' ({spec.use}) needs '{name}', {param.type_text}: {param.doc}"
            problems.append(Problem(spec.place, what, f"write with: {{{name}: ...}}"))
            continue
        place = entry.value.place if entry else spec.place
        try:
            value = param.parse(entry.value.plain()) if entry else param.default
        except ParamError as error:
            problems.append(Problem(place, f"{spec.use}: {error.what}", error.hint))
            continue
        settings[name] = _setting(param, value, entry, place, folders.get(place.file, folder))
    return settings


def _setting(param: Param, value: Any, entry: Entry | None, place: Place, folder: Path) -> Setting:
    origin = "default" if entry is None else SET if is_from_set(place) else "graph"
    if not has_path(param.type):
        return Setting(value, value, value, origin, place)
    found = resolve_paths(param.type, value, Path.cwd() if origin == SET else folder)
    return Setting(found.value, entry.value.plain() if entry else value, found.anywhere, origin, place)


def run_options(entries: Mapping[str, Entry], problems: list[Problem]) -> RunOptions:
    """Return what ``run:`` says; what is wrong is added to ``problems``."""
    declared = params_of(RunOptions)
    problems += _unknown(entries, declared, "'run' has no key")
    given: dict[str, Any] = {}
    for name, entry in entries.items():
        if name in declared:
            try:
                given[name] = declared[name].parse(entry.value.plain())
                if name == "url" and given[name] is not None:
                    check_url(given[name])
            except ParamError as error:
                problems.append(Problem(entry.value.place, f"run: {error.what}", error.hint))
    return RunOptions(**given)


def _unknown(entries: Mapping[str, Entry], declared: Mapping[str, Param], what: str) -> Iterator[Problem]:
    for name, entry in entries.items():
        if name not in declared:
            yield Problem(entry.place, f"{what} '{name}'", _hint(name, declared))


def _hint(name: str, declared: Mapping[str, Param]) -> str:
    for param in declared.values():
        if param.renamed_from == name:
            return f"did you mean '{param.name}'? It was renamed"
    return did_you_mean(name, declared) or (f"it has {', '.join(declared)}" if declared else "it has none")
