"""Parameters: what a graph gives, checked against what a stage declares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from graphnav.core.errors import ParamError, Place, Problem, did_you_mean
from graphnav.core.graph.node import SET, Origin, Setting
from graphnav.core.graph.paths import beside, has_path, resolve_paths
from graphnav.core.spec import Entry, RunKeys, RunOptions, StageSpec, Value, check_url, read_record
from graphnav.core.stage import Param, Stage, params_of


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
            written = _written(param, entry, folders) if entry else None
            value = param.parse(written) if entry else param.parsed_default
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


def param_problem(spec: StageSpec, settings: Mapping[str, Setting], error: ParamError) -> Problem:
    """Return what a stage says of its parameters as a problem at the parameter's place."""
    setting = settings.get(error.param)
    return Problem(setting.place if setting else spec.place, f"{spec.use}: {error.what}", error.hint)


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
    split = {name: entry for name, entry in entries.items() if name.startswith("record.")}
    hint = "its keys are set together: run.record={keep: small, rotate_mb: 500}"
    problems += [Problem(entry.place, f"run has no key '{name}'", hint, "unknown") for name, entry in split.items()]
    rest = {name: entry for name, entry in entries.items() if name not in split}
    keys, found = read_record(RunKeys, Value(rest, Place("run")))
    problems += found
    if keys is None:
        return RunOptions()
    try:
        if keys.url is not None:
            check_url(keys.url)
    except ParamError as error:
        problems.append(Problem(keys.place("url"), f"run: {error.what}", error.hint))
    return keys.options


def _unknown(entries: Mapping[str, Entry], declared: Mapping[str, Param], what: str) -> Iterator[Problem]:
    known = f"it has {', '.join(declared)}" if declared else "it has none"
    renamed = {param.renamed_from: param.name for param in declared.values() if param.renamed_from}
    for name, entry in entries.items():
        if name not in declared:
            hint = did_you_mean(name, declared, renamed) or known
            yield Problem(entry.place, f"{what} '{name}'", hint, "unknown")
