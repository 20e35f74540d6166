"""What ``--set`` says: a swap, a stage to add, a parameter, a time, a wire or a run option."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from graphnav.errors import Place, Problem, UserError, did_you_mean
from graphnav.graph.wiring.settings import SET
from graphnav.spec import TIME_KEYS, Entry, Spec, Value, parse_scalar, parse_yaml
from graphnav.spec.spec import RESERVED_STAGES, STAGE_NAME

ADD = "+"
"""What ends the target of a text that adds a stage: ``name+=family.stage``."""
_HINT = "write stage=family.stage, stage.parameter=value, stage.in.port=stage.port, run.key=value or name+=family.stage"
Kind = Literal["swap", "add", "param", "time", "wire", "run"]
_QUOTED = ("[", "{", '"', "'")


@dataclass(frozen=True)
class Assignment:
    """One thing that ``--set`` changes."""

    kind: Kind
    stage: str
    key: str
    text: str
    place: Place

    @property
    def entry(self) -> Entry:
        """The value as if it stood in the graph; words are taken as they are, all else by the rules of YAML.

        Raises
        ------
        UserError
            It is no YAML.
        """
        if self.kind == "wire":
            return Entry(self.place, Value(self.text, self.place))
        if not self.text.startswith(_QUOTED):
            return Entry(self.place, Value(parse_scalar(self.text), self.place))
        try:
            value, problems = parse_yaml(self.text.encode("utf-8", "replace"), "")
        except UserError as error:
            problems = error.problems
        if problems:
            raise UserError([Problem(self.place, problem.what, problem.hint) for problem in problems])
        return Entry(self.place, _moved(value, self.place))


def parse_sets(sets: Sequence[str], spec: Spec, problems: list[Problem]) -> list[Assignment]:
    """Return what ``--set`` options say; what is wrong is added to ``problems``."""
    found: dict[tuple[str, ...], Assignment] = {}
    stages = [*spec.stages, *(name for text in sets for name in _added_names(text))]
    for text in sets:
        place = Place(f"{SET} {text}")
        for assignment in _parse(text, place, stages, spec.stages, problems):
            target = (assignment.kind, assignment.stage, assignment.key)
            if target in found:
                what = f"this is also said by '{found[target].place}'"
                problems.append(Problem(place, what, "keep one"))
            found.setdefault(target, assignment)
    usable = {"", *spec.stages, *(a.stage for a in found.values() if a.kind == "add")}
    return [a for a in found.values() if a.stage in usable]


def _added_names(text: str) -> list[str]:
    """Return the names of the stages that a text adds."""
    target, equals, _ = text.partition("=")
    is_add = bool(equals) and target.endswith(ADD) and "." not in target
    return target.removesuffix(ADD).split(",") if is_add else []


def _parse(
    text: str, place: Place, stages: Sequence[str], existing: Container[str], problems: list[Problem]
) -> list[Assignment]:
    """Return what one text says; ``stages``: the ``existing`` ones of the graph and those that are added."""
    target, equals, value = text.partition("=")
    names, dot, key = target.partition(".")
    if not equals or not names or (dot and not key):
        problems.append(Problem(place, "this says nothing to set", _HINT))
        return []
    if added := _added_names(text):
        return list(_adds(added, value, place, existing, problems))
    if names == "run":
        if dot:
            return [Assignment("run", "", key, value, place)]
        problems.append(Problem(place, "'run' is no stage", "write run.key=value"))
        return []
    known = [name for name in names.split(",") if name in stages]
    for name in names.split(","):
        if name not in stages:
            hint = did_you_mean(name, stages) or f"stages are {', '.join(stages)}"
            problems.append(Problem(place, f"there is no stage '{name}'", hint))
    if not dot:
        return [Assignment("swap", name, "", value, place) for name in known]
    if key.endswith(ADD):
        what = f"'{ADD}=' adds a stage, and '{target.removesuffix(ADD)}' is not the name of one"
        problems.append(Problem(place, what, "write name+=family.stage"))
        return []
    if key.startswith("in."):
        return [Assignment("wire", name, key.removeprefix("in."), value, place) for name in known]
    kind: Kind = "time" if key in TIME_KEYS else "param"
    return [Assignment(kind, name, key, value, place) for name in known]


def _adds(
    names: Iterable[str], use: str, place: Place, existing: Container[str], problems: list[Problem]
) -> Iterator[Assignment]:
    for name in names:
        if name in existing:
            hint = f"choose another name, or swap it with {SET} {name}={use}"
            problems.append(Problem(place, f"there is a stage '{name}' already", hint))
        elif not STAGE_NAME.fullmatch(name):
            hint = "use small letters, digits and _, beginning with a letter"
            problems.append(Problem(place, f"'{name}' cannot be a stage's name", hint))
        elif name in RESERVED_STAGES:
            problems.append(Problem(place, f"no stage can be called '{name}'", "choose another name"))
        else:
            yield Assignment("add", name, "", use, place)


def _moved(value: Value, place: Place) -> Value:
    if isinstance(value.data, list):
        return Value([_moved(item, place) for item in value.data], place)
    if isinstance(value.data, dict):
        return Value({key: Entry(place, _moved(entry.value, place)) for key, entry in value.data.items()}, place)
    return Value(value.data, place)
