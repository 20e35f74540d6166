"""Read a study file."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from graphnav import Place, Problem, UserError, Value, shown_path
from graphnav.core.graph import Override, Target, find_graph
from graphnav.core.spec import parse_scalar, write_value
from graphnav.studies.ablation.study.find_study import find, read
from graphnav.studies.ablation.study.study import Axis, Choice, Study
from graphnav.studies.ablation.study.study_keys import STUDY, Choices, Settings, StudyKeys
from graphnav.studies.ablation.study.vary import axis_problems, name_problems, plain_choice
from graphnav.studies.ablation.study.worlds import checked_seeds, parse_seeds, unknown_graph

_NUMBER = re.compile(r"[^\s,\[\]{}#]+")


class SourceText:
    """The text of a file, to look up how its values were written."""

    def __init__(self, data: bytes) -> None:
        self._lines = data.decode("utf-8-sig", "replace").splitlines()

    def label(self, value: Value) -> str:
        """Return a value as tables show it: 0.50 stays 0.50, strings have no quotes."""
        return value.data if isinstance(value.data, str) and value.data.isprintable() else self._item(value)

    def _item(self, value: Value) -> str:
        if isinstance(value.data, list):
            return "[" + ", ".join(map(self._item, value.data)) + "]"
        if isinstance(value.data, int | float) and not isinstance(value.data, bool):
            line = self._lines[value.place.line - 1][value.place.column - 1 :]
            token = _NUMBER.match(line)
            if token and repr(parse_scalar(token[0])) == repr(value.data):
                return token[0]
        return write_value(value.plain())


@dataclass(frozen=True)
class OverrideReader:
    """Reads the overrides of one file in ``folder``; adds what is wrong to ``problems``."""

    folder: Path
    problems: list[Problem]

    def mapping(self, settings: Settings) -> tuple[Override, ...]:
        """Return the overrides of targets and their values."""
        found = []
        for text, value in settings.items():
            if isinstance(value.data, dict) and "." not in text:
                what = f"the value of '{text}' is a mapping"
                self.problems.append(Problem(value.place, what, "write stage.parameter: value"))
            elif (target := self.target(text, value.place)) is not None:
                found.append(self.override(target, value))
        return tuple(found)

    def texts(self, texts: Mapping[str, Place]) -> tuple[Override, ...]:
        """Return the overrides of strings ``target=value``."""
        return tuple(self._texts(texts.items()))

    def target(self, text: str, place: Place) -> Target | None:
        """Return a target, None where it is not one."""
        try:
            return Target.parse(text, place)
        except UserError as error:
            self.problems.extend(error.problems)
            return None

    def override(self, target: Target, value: Value) -> Override:
        """Return the override of a target by a value of the file."""
        return Override(target, value.plain(), value.place, self.folder)

    def _texts(self, texts: Iterable[tuple[str, Place]]) -> Iterable[Override]:
        for text, place in texts:
            try:
                yield replace(Override.parse(text, place), folder=self.folder)
            except UserError as error:
                self.problems.extend(error.problems)


def axes_of(keys: StudyKeys, source: SourceText, reader: OverrideReader) -> tuple[Axis, ...]:
    """Return the axes under ``vary``: lists of what a target becomes, or mappings of labels to what each sets."""
    axes, problems = [], reader.problems
    for name, choices in keys.vary.items():
        before, place = len(problems), keys.key_place("vary", name)
        problems.extend(name_problems(name, place))
        axis = Axis(name, _choices(name, choices, keys, source, reader), place)
        if len(problems) == before:
            problems.extend(axis_problems(axis))
        axes.append(axis)
    if not axes and not problems:
        hint = "write vary: {plane: [plane.ica, plane.affine]}"
        problems.append(Problem(keys.key_place("vary"), "the study varies nothing", hint))
    return tuple(axes)


def _choices(
    axis: str, choices: Choices, keys: StudyKeys, source: SourceText, reader: OverrideReader
) -> tuple[Choice, ...]:
    if isinstance(choices, Mapping):
        return tuple(
            Choice(label, reader.mapping(settings or {}), keys.key_place("vary", axis, label))
            for label, settings in choices.items()
        )
    place = keys.key_place("vary", axis)
    target = None if place is None or any(name_problems(axis, place)) else reader.target(axis, place)
    return tuple(_plain(target, value, source, reader) for value in choices or ()) if target is not None else ()


def _plain(target: Target, value: Value, source: SourceText, reader: OverrideReader) -> Choice:
    if isinstance(value.data, dict):
        hint = f"name a choice that sets several things: {target}: {{label: {{stage.parameter: value}}}}"
        reader.problems.append(Problem(value.place, f"axis '{target}': a value in a list cannot be a mapping", hint))
    return plain_choice(reader.override(target, value), source.label(value), value.place)


Texts = dict[str, Place]
"""Strings, each with its location."""


def load_study(name_or_path: str | Path) -> Study:
    """Return the study of a file, or of the name of one in the working folder or among those that ship.

    Its graphs are those beside it, else those that `find_graph` finds. What a variant changes is checked with the
    graphs, by `make_plan`.

    Raises
    ------
    UserError
        Everything that is wrong with the file.
    """
    path = find(name_or_path)
    data = read(path)
    keys, problems = STUDY.parse(data, shown_path(path))
    study = _study(keys, path, SourceText(data), problems) if keys else None
    if study is None or problems:
        raise UserError(dict.fromkeys(problems))
    return study


def _study(keys: StudyKeys, path: Path, source: SourceText, problems: list[Problem]) -> Study:
    graphs = _graphs(keys, path, problems)
    within, metrics = (_texts(keys, word, problems) for word in ("within", "metrics"))
    reader = OverrideReader(path.resolve().parent, problems)
    given = keys.set
    overrides = reader.mapping(given) if isinstance(given, Mapping) else reader.texts(_texts(keys, "set", problems))
    return Study(
        name=path.stem,
        about=keys.about,
        graphs=tuple(graphs),
        axes=axes_of(keys, source, reader),
        seeds=_seeds(keys, problems),
        overrides=overrides,
        metrics=tuple(metrics),
        within=tuple(within),
        one_at_a_time=keys.one_at_a_time,
        reference=keys.reference,
        worlds=_worlds(keys, path, graphs, problems),
        places=graphs | metrics | within | _reference(keys),
    )


def _texts(keys: StudyKeys, word: str, problems: list[Problem]) -> Texts:
    """Return the strings under a key, one or a list, each with its place."""
    given = getattr(keys, word)
    listed = [((word, str(number)), text) for number, text in enumerate(given or ())]
    each = [((word,), given)] if isinstance(given, str) else listed
    found: Texts = {}
    for path, text in each:
        place = keys.place(*path)
        if text in found:
            problems.append(Problem(place, f"duplicate entry '{text}'", "keep one"))
        elif place:
            found[text] = place
    return found


def _graphs(keys: StudyKeys, path: Path, problems: list[Problem]) -> Texts:
    """Return the graphs as they are called from the working folder."""
    files: dict[Path, str] = {}
    shown: Texts = {}
    for name, place in [item for word in ("graph", "graphs") for item in _texts(keys, word, problems).items()]:
        try:
            called = _beside(name, path)
            file = find_graph(called).resolve()
        except UserError as error:
            problems += [Problem(place, f"'{name}': {p.what}", p.hint) for p in error.problems]
            continue
        if file in files:
            problems.append(Problem(place, f"'{name}' is the same graph as '{files[file]}'", "keep one"))
        files.setdefault(file, name)
        shown[called] = place
    return shown


def _worlds(keys: StudyKeys, path: Path, graphs: Texts, problems: list[Problem]) -> dict[str, int]:
    """Return the number of worlds of each graph that has its own, by the graph as it is called."""
    found: dict[str, int] = {}
    for name, number in (keys.worlds or {}).items():
        called = _beside(name, path)
        if called in graphs:
            found[called] = number
        else:
            problems.append(unknown_graph(name, graphs, keys.key_place("worlds", name)))
    return found


def _reference(keys: StudyKeys) -> Texts:
    place = keys.place("reference")
    return {keys.reference: place} if keys.reference and place else {}


def _beside(name: str, study: Path) -> str:
    """Return the path of a graph that is beside the study, from the working folder; another's name as it is."""
    folder = study.resolve().parent
    for file in (folder / name, folder / f"{name}.yaml", folder / f"{name}.yml"):
        if file != study.resolve() and _is_file(file):
            return name if folder == Path.cwd() else shown_path(file)
    return name


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long
        return False


def _seeds(keys: StudyKeys, problems: list[Problem]) -> tuple[int, ...]:
    place, given = keys.place("seeds"), keys.seeds
    try:
        return parse_seeds(given, place) if isinstance(given, str) else checked_seeds(given, place) if given else ()
    except UserError as error:
        problems += error.problems
        return ()
