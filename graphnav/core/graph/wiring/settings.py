"""Parameters: what a graph gives, checked against what a stage declares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

from graphnav.core.errors import ParamError, Place, Problem, did_you_mean
from graphnav.core.graph.node import Origin, Setting
from graphnav.core.graph.paths import beside, has_path, resolve_paths
from graphnav.core.spec import RECORD_KEYS, Entry, RunOptions, StageSpec, check_url
from graphnav.core.stage import Param, Stage, params_of

SET: Literal["--set"] = "--set"
"""The origin of what an override gives, wherever it was written."""


def settings_of(
    spec: StageSpec,
    cls: type[Stage],
    folder: Path,
    problems: list[Problem],
    folders: Mapping[str, Path] = MappingProxyType({}),
) -> dict[str, Setting]:
    """Return every parameter of a stage with its value; what is wrong is added to ``problems``.

    ``folder`` is the graph's own: its paths resolve against it, those of a file that the graph extends against that of
    ``folders``, by the file's name in places. Paths of an override are looked for in the folder of its file, if it was
    written in one, then in the working folder.
    """
    declared = params_of(cls)
    problems += _unknown(spec.params, declared, f"{spec.use} has no parameter")
    settings = {}
    for name, param in declared.items():
        entry = spec.params.get(name)
        if entry is None and param.required:
            near = (did_you_mean(word, declared).names for word in spec.params)
            if spec.unclear or param.renamed_from in spec.params or any(name in names for names in near):
                continue
            what = f"stage '{spec.name}' ({spec.use}) needs '{name}', {param.type_text}: {param.doc}"
            problems.append(Problem(spec.place, what, f"write with: {{{name}: ...}}"))
            continue
        place = entry.value.place if entry else spec.place
        try:
            written = _written(param, entry, folders) if entry else param.default
            value = param.parse(written)
        except ParamError as error:
            problems.append(_problem(spec, error, place, is_default=entry is None))
            continue
        origin: Origin = "default" if entry is None else SET if entry.is_override else "graph"
        if has_path(param.type):
            found = resolve_paths(param.type, value, Path.cwd() if origin == SET else folders.get(place.file, folder))
            settings[name] = Setting(found.value, written if entry else value, found.anywhere, origin, place)
        else:
            settings[name] = Setting(value, value, value, origin, place)
    return settings


def _problem(spec: StageSpec, error: ParamError, place: Place, *, is_default: bool) -> Problem:
    """Return what is wrong with the value of a parameter; a default, which is not in the graph, is named as one."""
    if not is_default:
        return Problem(place, f"{spec.use}: {error.what}", error.hint)
    what = f"stage '{spec.name}' ({spec.use}): default of '{error.param}': {error.what}"
    return Problem(place, what, f"write with: {{{error.param}: ...}}, or fix the plugin")


def _written(param: Param, entry: Entry, folders: Mapping[str, Path]) -> Any:
    """Return the plain value of a parameter; paths of an override are absolute where they are beside its file."""
    value, folder = entry.value.plain(), folders.get(entry.value.place.file)
    return beside(value, folder) if entry.is_override and folder and has_path(param.type) else value


def run_options(entries: Mapping[str, Entry], problems: list[Problem]) -> RunOptions:
    """Return what ``run:`` says; what is wrong is added to ``problems``."""
    declared = params_of(RunOptions)
    top = {name: param for name, param in declared.items() if name not in RECORD_KEYS.values() or name == "record"}
    problems += _unknown(entries, top, "'run' has no key")
    given: dict[str, Any] = {}
    for name, entry in _flat(entries, declared, problems).items():
        if name in declared:
            try:
                given[name] = declared[name].parse(entry.value.plain())
                if name == "url" and given[name] is not None:
                    check_url(given[name])
            except ParamError as error:
                problems.append(Problem(entry.value.place, f"run: {error.what}", error.hint))
    return RunOptions(**given)


def _flat(entries: Mapping[str, Entry], declared: Mapping[str, Param], problems: list[Problem]) -> dict[str, Entry]:
    """Return the entries of ``run``, in which ``record`` may be a mapping, by the names of options."""
    found = {name: entry for name, entry in entries.items() if name not in RECORD_KEYS.values() or name == "record"}
    record = found.get("record")
    if record is not None and isinstance(record.value.data, dict):
        del found["record"]
        words: dict[str, Entry] = record.value.data
        problems += _unknown(words, {key: declared[name] for key, name in RECORD_KEYS.items()}, "'record' has no key")
        found |= {RECORD_KEYS[key]: entry for key, entry in words.items() if key in RECORD_KEYS}
    return found


def _unknown(entries: Mapping[str, Entry], declared: Mapping[str, Param], what: str) -> Iterator[Problem]:
    known = f"it has {', '.join(declared)}" if declared else "it has none"
    together = "its keys are set together: run.record={keep: small, rotate_mb: 500}"
    renamed = {param.renamed_from: param.name for param in declared.values() if param.renamed_from}
    for name, entry in entries.items():
        if name not in declared:
            hint = together if name.startswith("record.") else did_you_mean(name, declared, renamed) or known
            yield Problem(entry.place, f"{what} '{name}'", hint, "unknown")
