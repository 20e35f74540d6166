"""What ``--set`` says: a swap, a parameter, a wire or a run option."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from graphnav.errors import Place, Problem, UserError, did_you_mean
from graphnav.graph.settings import SET
from graphnav.spec import Entry, Spec, Value, parse_scalar, parse_yaml

_HINT = "write stage=family.stage, stage.parameter=value, stage.in.port=stage.port or run.key=value"
_QUOTED = ("[", "{", '"', "'")


@dataclass(frozen=True)
class Assignment:
    """One thing that ``--set`` changes."""

    kind: Literal["swap", "param", "wire", "run"]
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
    for text in sets:
        place = Place(f"{SET} {text}")
        for assignment in _parse(text, place, spec, problems):
            target = (assignment.kind, assignment.stage, assignment.key)
            if target in found:
                what = f"this is also said by '{found[target].place}'"
                problems.append(Problem(place, what, "keep one"))
            found.setdefault(target, assignment)
    return list(found.values())


def _parse(text: str, place: Place, spec: Spec, problems: list[Problem]) -> list[Assignment]:
    target, equals, value = text.partition("=")
    names, dot, key = target.partition(".")
    if not equals or not names or (dot and not key):
        problems.append(Problem(place, "this says nothing to set", _HINT))
        return []
    if names == "run":
        if dot:
            return [Assignment("run", "", key, value, place)]
        problems.append(Problem(place, "'run' is no stage", "write run.key=value"))
        return []
    known = []
    for name in names.split(","):
        if name in spec.stages:
            known.append(name)
        else:
            hint = did_you_mean(name, spec.stages) or f"stages are {', '.join(spec.stages)}"
            problems.append(Problem(place, f"there is no stage '{name}'", hint))
    if not dot:
        return [Assignment("swap", name, "", value, place) for name in known]
    if key.startswith("in."):
        return [Assignment("wire", name, key.removeprefix("in."), value, place) for name in known]
    return [Assignment("param", name, key, value, place) for name in known]


def _moved(value: Value, place: Place) -> Value:
    if isinstance(value.data, list):
        return Value([_moved(item, place) for item in value.data], place)
    if isinstance(value.data, dict):
        return Value({key: Entry(place, _moved(entry.value, place)) for key, entry in value.data.items()}, place)
    return Value(value.data, place)
