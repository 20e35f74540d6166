"""Read a study from its YAML file, every part with its place."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from graphnav.ablation.axes import axis_problems, plain_choice
from graphnav.ablation.find_study import STUDY_KEYS, find, read
from graphnav.ablation.seeds import bare_number, checked_seeds, parse_seeds
from graphnav.ablation.study import Axis, Choice, Study
from graphnav.ablation.written import Written
from graphnav.errors import Place, Problem, UserError, did_you_mean, shown_path
from graphnav.graph import find_graph
from graphnav.spec import Entry, Value, parse_yaml

_VARY = "write vary: {plane: [plane.ica, plane.affine]}"


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
    reader = _Reader(path, Written(data), problems)
    study = reader.study(value)
    if problems:
        raise UserError(dict.fromkeys(problems))
    return study


class _Reader:
    def __init__(self, path: Path, written: Written, problems: list[Problem]) -> None:
        self._path, self._written, self._problems = path, written, problems
        self._places: dict[str, Place] = {}

    def study(self, value: Value) -> Study:
        words = value.data if isinstance(value.data, dict) else {}
        if value.data is not None and not isinstance(value.data, dict):
            self._problem(value.place, f"a study must be a mapping, not {value.kind}", _VARY)
        else:
            self._keys(words, value.place)
        return Study(
            name=self._path.stem,
            about=self._typed(words, "about", str, "a text", "put it in quotes if it is meant") or "",
            graphs=self._graphs(words),
            axes=self._axes(words),
            seeds=self._seeds(words["seeds"].value) if "seeds" in words else (),
            sets=self._sets(words["set"].value, "'set'") if "set" in words else (),
            figures=self._texts(words["figures"].value, "'figures'") if "figures" in words else (),
            one_at_a_time=self._typed(words, "one_at_a_time", bool, "true or false") or False,
            folder=self._path.resolve().parent,
            places=self._places,
        )

    def _keys(self, words: dict[str, Entry], place: Place) -> None:
        for word, entry in words.items():
            if word not in STUDY_KEYS:
                hint = did_you_mean(word, STUDY_KEYS) or f"keys are {', '.join(STUDY_KEYS)}"
                self._problem(entry.place, f"a study has no key '{word}'", hint)
        if "graph" in words and "graphs" in words:
            self._problem(words["graphs"].place, "the study has 'graph' and 'graphs'", "keep one")
        if "graph" not in words and "graphs" not in words:
            self._problem(place, "the study has no graphs", "write graphs: [corridor_ccw, pillars]")
        if "vary" not in words:
            self._problem(place, "the study varies nothing", _VARY)

    def _graphs(self, words: dict[str, Entry]) -> tuple[str, ...]:
        found: dict[Path, str] = {}
        for key in ("graph", "graphs"):
            for name in self._texts(words[key].value, f"'{key}'") if key in words else ():
                place = self._places.pop(name)
                try:
                    shown, file = self._graph(name)
                except UserError as error:
                    self._problems += [Problem(place, f"'{name}': {p.what}", p.hint) for p in error.problems]
                    continue
                if file in found:
                    self._problem(place, f"'{name}' is the same graph as '{found[file]}'", "keep one")
                found.setdefault(file, shown)
                self._places[shown] = place
        return tuple(found.values())

    def _graph(self, name: str) -> tuple[str, Path]:
        """Return what a graph is called from the working folder, and its file."""
        beside = self._path.resolve().parent / name
        for file in (beside, beside.with_name(f"{beside.name}.yaml"), beside.with_name(f"{beside.name}.yml")):
            if file.is_file() and file != self._path.resolve():
                return (name if self._path.parent == Path() else shown_path(file)), file.resolve()
        return name, find_graph(name).resolve()

    def _axes(self, words: dict[str, Entry]) -> tuple[Axis, ...]:
        if "vary" not in words:
            return ()
        vary = words["vary"]
        if not isinstance(vary.value.data, dict):
            said = "varies nothing" if vary.value.data in (None, []) else f"varies {vary.value.kind}"
            self._problem(vary.place, f"the study {said}: 'vary' must be a mapping of axes", _VARY)
            return ()
        if not vary.value.data:
            self._problem(vary.place, "the study varies nothing", _VARY)
        axes = []
        for name, entry in vary.value.data.items():
            before = len(self._problems)
            axis = Axis(name, self._choices(name, entry), entry.place)
            if len(self._problems) == before:
                self._problems += axis_problems(axis)
            axes.append(axis)
        return tuple(axes)

    def _choices(self, axis: str, entry: Entry) -> tuple[Choice, ...]:
        data = entry.value.data
        if isinstance(data, dict):
            return tuple(self._named(axis, label, choice) for label, choice in data.items())
        if isinstance(data, list):
            return tuple(self._plain(axis, item) for item in data)
        if data is not None:
            hint = f"write [{self._written.label(entry.value)}, ...]"
            self._problem(entry.value.place, f"axis '{axis}' must be a list or a mapping, not {entry.value.kind}", hint)
            return ()
        return ()

    def _plain(self, axis: str, item: Value) -> Choice:
        if isinstance(item.data, dict):
            hint = f"name what sets several things: {axis}: {{label: {{stage.parameter: value}}}}"
            self._problem(item.place, f"a value of axis '{axis}' is a mapping", hint)
        return plain_choice(axis, self._written.text(item), item.place, self._written.label(item))

    def _named(self, axis: str, label: str, entry: Entry) -> Choice:
        before = dict(self._places)
        sets: tuple[str, ...] = ()
        if isinstance(entry.value.data, dict | None):
            sets = self._sets(entry.value, f"'{label}'") if entry.value.data else ()
        else:
            hint = f"write {label}: {{{axis}: {self._written.label(entry.value)}}}"
            what = f"choice '{label}' of axis '{axis}' must be a mapping of what it sets, not {entry.value.kind}"
            self._problem(entry.value.place, what, hint)
        places = tuple(self._places[text] for text in sets)
        self._places = before
        return Choice(label, sets, places, entry.place)

    def _sets(self, value: Value, who: str) -> tuple[str, ...]:
        """Return ``--set`` texts of a list of them, or of a mapping of targets to values."""
        if not isinstance(value.data, dict):
            return self._texts(value, who, "run.until_s=60")
        found = []
        for target, entry in value.data.items():
            if isinstance(entry.value.data, dict):
                self._problem(
                    entry.value.place, f"the value of '{target}' is a mapping", "write stage.parameter: value"
                )
            text = f"{target}={self._written.text(entry.value)}"
            self._places[text] = entry.value.place if entry.value.place.line else entry.place
            found.append(text)
        return tuple(found)

    def _texts(self, value: Value, who: str, example: str = "") -> tuple[str, ...]:
        """Return the texts of a list, or the one text; each is put down with its place."""
        items = value.data if isinstance(value.data, list) else [value]
        found: list[str] = []
        for item in items:
            if not isinstance(item.data, str):
                hint = f"write [{example}]" if example else "put it in quotes if it is meant"
                self._problem(item.place, f"{who} must be a list of texts, but this is {item.kind}", hint)
            elif item.data in found:
                self._problem(item.place, f"'{item.data}' stands here twice", "keep one")
            else:
                found.append(item.data)
                self._places[item.data] = item.place
        if not items:
            self._problem(value.place, f"{who} is an empty list", "name at least one, or leave the key out")
        return tuple(found)

    def _seeds(self, value: Value) -> tuple[int, ...]:
        try:
            if isinstance(value.data, str):
                return parse_seeds(value.data, value.place)
            if type(value.data) is int:
                raise bare_number(str(value.data), value.place)
            if isinstance(value.data, list) and all(type(item.data) is int for item in value.data):
                return checked_seeds([item.plain() for item in value.data], value.place)
        except UserError as error:
            self._problems += error.problems
            return ()
        hint = "write FIRST:END, the end not included, or a list as [1, 5, 7]"
        self._problem(value.place, "'seeds' must be FIRST:END or a list of whole numbers", hint)
        return ()

    def _typed(self, words: dict[str, Entry], key: str, kind: type, said: str, hint: str = "") -> Any:
        if key not in words or isinstance(words[key].value.data, kind):
            return words[key].value.data if key in words else None
        value = words[key].value
        self._problem(value.place, f"'{key}' must be {said}, not {value.kind}", hint)
        return None

    def _problem(self, place: Place, what: str, hint: str = "") -> None:
        self._problems.append(Problem(place, what, hint))
