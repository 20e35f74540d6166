"""Everything that is wrong with the cases of a study, each said once and where the study says it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from graphnav.ablation.study import Axis
from graphnav.errors import Place, Problem, UserError
from graphnav.graph.settings import SET


@dataclass(frozen=True)
class Origin:
    """Where a ``--set`` text of a case was said: by a choice of an axis, or for all runs (both empty)."""

    place: Place | None
    axis: str = ""
    choice: str = ""


_Finding = tuple[Origin | None, Problem]
"""What is wrong; without an origin, the graph itself says it."""


class Findings:
    """Collects the errors of cases."""

    def __init__(self, axes: Iterable[Axis]) -> None:
        self._axes = {axis.name: axis for axis in axes}
        self._found: dict[_Finding, dict[str, list[str]]] = {}
        self._seen: dict[str, int] = {}

    def saw(self, graph: str) -> None:
        """Note that a case of a graph was looked at."""
        self._seen[graph] = self._seen.get(graph, 0) + 1

    def add(self, graph: str, variant: str, error: UserError, origins: Mapping[str, Origin]) -> None:
        """Add what is wrong with a case; ``origins``: of its ``--set`` texts."""
        for problem in error.problems:
            said = problem.place.file.removeprefix(f"{SET} ") if problem.place else ""
            origin = origins.get(said)
            hint = _in_one_choice(problem.hint) if origin and origin.axis else problem.hint
            moved = Problem(origin.place if origin else problem.place, problem.what, hint)
            variants = self._found.setdefault((origin, moved), {}).setdefault(graph, [])
            if variant not in variants:
                variants.append(variant)

    def problems(self) -> list[Problem]:
        """Return what is wrong: what all choices of an axis have at the axis, all else where it was said."""
        choices: dict[tuple[str, str, str], set[str]] = {}
        for origin, problem in self._found:
            if origin and origin.axis:
                choices.setdefault((origin.axis, problem.what, problem.hint), set()).add(origin.choice)
        graphs: dict[Problem, list[str]] = {}
        said = []
        for (origin, problem), where in self._found.items():
            if origin is None:
                said.append(self._with_variant(problem, where))
                continue
            axis, place = self._axes.get(origin.axis), problem.place
            if axis and 1 < len(axis.choices) == len(choices[axis.name, problem.what, problem.hint]):
                place = axis.place
            graphs.setdefault(Problem(place, problem.what, problem.hint), []).extend(where)
        said += [Problem(p.place, f"in {listed(list(dict.fromkeys(g)))}: {p.what}", p.hint) for p, g in graphs.items()]
        return said

    def _with_variant(self, problem: Problem, where: Mapping[str, Sequence[str]]) -> Problem:
        """Return a problem of a graph with a variant that has it, unless all have."""
        for graph, variants in where.items():
            if len(variants) < self._seen[graph]:
                return Problem(problem.place, f"with {variants[0]}: {problem.what}", problem.hint)
        return problem


def _in_one_choice(hint: str) -> str:
    """Return the advice of a swap for a study, where ``--set`` would change the other variants, too."""
    head, option, rest = hint.partition(f"choose with {SET} ")
    return f"{head}write a choice that sets this, too: {rest.replace(f'{SET} ', '')}" if option else hint


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them, at most three."""
    if len(names) > 4:
        return f"{', '.join(names[:3])} and {len(names) - 3} more"
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
