"""Read a study from its YAML file, every part with its place."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from graphnav.core.errors import Place, Problem, UserError, shown_path
from graphnav.core.graph import find_graph
from graphnav.studies.ablation.study.find_study import find, read
from graphnav.studies.ablation.study.read_axes import axes_of
from graphnav.studies.ablation.study.read_overrides import OverrideReader
from graphnav.studies.ablation.study.seeds import checked_seeds, parse_seeds
from graphnav.studies.ablation.study.source_text import SourceText
from graphnav.studies.ablation.study.study import Study
from graphnav.studies.ablation.study.study_keys import STUDY, StudyKeys
from graphnav.studies.ablation.study.worlds import unknown_graph

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
