"""Read a study from its YAML file, every part with its place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from graphnav.ablation.study.find_study import STUDY_KEYS, find, read
from graphnav.ablation.study.read_axes import VARY, axes_of
from graphnav.ablation.study.seeds import HINT, bare_number, checked_seeds, parse_seeds
from graphnav.ablation.study.source_text import SourceText
from graphnav.ablation.study.study import Study
from graphnav.ablation.study.value_reader import Texts, ValueReader
from graphnav.errors import Place, Problem, UserError, shown_path
from graphnav.graph import find_graph
from graphnav.spec import Entry, Value, parse_yaml
from graphnav.stage import former_names


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
    value, problems = parse_yaml(data, shown_path(path))
    if problems:
        raise UserError(problems)
    study = _study(value, path, ValueReader(SourceText(data), problems))
    if problems:
        raise UserError(dict.fromkeys(problems))
    return study


def _study(value: Value, path: Path, reader: ValueReader) -> Study:
    keys = value.data if isinstance(value.data, dict) else {}
    if isinstance(value.data, dict | None):
        _check_keys(keys, value.place, reader)
    else:
        reader.problem(value.place, f"a study must be a mapping, not {value.kind}", VARY)
    graphs = _graphs(keys, path, reader)
    sets = reader.sets(keys["set"].value, "'set'") if "set" in keys else {}
    within = reader.texts(keys["within"].value, "'within'", "speed") if "within" in keys else {}
    metrics = reader.texts(keys["metrics"].value, "'metrics'", "drive.success, drive.spl") if "metrics" in keys else {}
    return Study(
        name=path.stem,
        about=_typed(keys, "about", str, "a text", reader) or "",
        graphs=tuple(graphs),
        axes=axes_of(keys["vary"], reader) if "vary" in keys else (),
        seeds=_seeds(keys["seeds"].value, reader) if "seeds" in keys else (),
        sets=tuple(sets),
        metrics=tuple(metrics),
        within=tuple(within),
        one_at_a_time=_typed(keys, "one_at_a_time", bool, "true or false", reader) or False,
        folder=path.resolve().parent,
        places=graphs | sets | metrics | within,
    )


def _check_keys(keys: dict[str, Entry], place: Place, reader: ValueReader) -> None:
    for word, entry in keys.items():
        if word not in STUDY_KEYS:
            hint = (
                former_names.suggestion(word, former_names.STUDY_KEYS, STUDY_KEYS)
                or f"keys are {', '.join(STUDY_KEYS)}"
            )
            reader.problem(entry.place, f"a study has no key '{word}'", hint)
    if "graph" in keys and "graphs" in keys:
        reader.problem(keys["graphs"].place, "the study has 'graph' and 'graphs'", "keep one")
    if "graph" not in keys and "graphs" not in keys:
        reader.problem(place, "the study has no graphs", "write graphs: [corridor_ccw, pillars]")
    if "vary" not in keys:
        reader.problem(place, "the study varies nothing", VARY)


def _graphs(keys: dict[str, Entry], path: Path, reader: ValueReader) -> Texts:
    """Return the graphs as they are called from the working folder."""
    files: dict[Path, str] = {}
    shown: Texts = {}
    said = [reader.texts(keys[key].value, f"'{key}'", "corridor_ccw") for key in ("graph", "graphs") if key in keys]
    for name, place in [item for texts in said for item in texts.items()]:
        try:
            called = _beside(name, path)
            file = find_graph(called).resolve()
        except UserError as error:
            reader.problems += [Problem(place, f"'{name}': {p.what}", p.hint) for p in error.problems]
            continue
        if file in files:
            reader.problem(place, f"'{name}' is the same graph as '{files[file]}'", "keep one")
        files.setdefault(file, name)
        shown[called] = place
    return shown


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


def _seeds(value: Value, reader: ValueReader) -> tuple[int, ...]:
    try:
        if isinstance(value.data, str):
            return parse_seeds(value.data, value.place)
        if isinstance(value.data, list) and all(type(item.data) is int for item in value.data):
            return checked_seeds([item.plain() for item in value.data], value.place)
        if type(value.data) is int:
            raise bare_number(str(value.data), value.place)
    except UserError as error:
        reader.problems += error.problems
        return ()
    wrong = next((i for i in value.data if type(i.data) is not int), value) if isinstance(value.data, list) else value
    reader.problem(wrong.place, f"'seeds' must be FIRST:END or a list of whole numbers, but this is {wrong.kind}", HINT)
    return ()


def _typed(keys: dict[str, Entry], key: str, kind: type, said: str, reader: ValueReader) -> Any:
    if key not in keys:
        return None
    value = keys[key].value
    if not isinstance(value.data, kind):
        reader.problem(value.place, f"'{key}' must be {said}, not {value.kind}")
        return None
    return value.data
