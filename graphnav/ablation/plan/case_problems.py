"""Collect the problems of all cases of a study, and report each once, at its place in the study."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from graphnav.ablation.plan.variants import Variant
from graphnav.ablation.study import Axis
from graphnav.errors import Place, Problem, UserError
from graphnav.graph.wiring.settings import SET


@dataclass(frozen=True)
class Origin:
    """The place of a ``--set`` text of a case: in a choice of an axis, or for all runs (both empty)."""

    place: Place | None
    axis: str = ""
    choice: str = ""


_CaseProblem = tuple[Origin | None, Problem]
"""A problem; without an origin it is in the graph itself."""


class CaseProblems:
    """Collects the errors of cases."""

    def __init__(self, axes: Iterable[Axis]) -> None:
        self._axes = {axis.name: axis for axis in axes}
        self._found: dict[_CaseProblem, dict[str, list[Variant]]] = {}
        self._seen: Counter[str] = Counter()

    def count_case(self, graph: str) -> None:
        """Count a case of a graph as checked."""
        self._seen[graph] += 1

    def add(self, graph: str, variant: Variant, error: UserError, origins: Mapping[str, Origin]) -> None:
        """Add what is wrong with a case; ``origins``: of its ``--set`` texts."""
        for problem in dict.fromkeys(error.problems):
            said = problem.place.file.removeprefix(f"{SET} ") if problem.place else ""
            finding = origins.get(said), problem
            self._found.setdefault(finding, {}).setdefault(graph, []).append(variant)

    def problems(self) -> list[Problem]:
        """Return what is wrong: what all choices of an axis have at the axis, all else where it was said.

        What a graph says, but only with some variants, is said at the choice that all of them have in common.
        """
        said: dict[Problem, None] = {}
        found: dict[tuple[Origin, str, str], list[str]] = {}
        for (origin, problem), where in self._found.items():
            by = origin or self._common_choice(where)
            if by is None:
                said[problem] = None
            else:
                hint = _in_one_choice(problem.hint) if by.axis else problem.hint
                found.setdefault((by, problem.what, hint), []).extend(where)
        choices: dict[tuple[str, str, str], set[str]] = {}
        for origin, what, hint in found:
            choices.setdefault((origin.axis, what, hint), set()).add(origin.choice)
        graphs: dict[Problem, list[str]] = {}
        for (origin, what, hint), names in found.items():
            axis = self._axes.get(origin.axis)
            is_whole = axis is not None and 1 < len(axis.choices) == len(choices[origin.axis, what, hint])
            place = axis.place if axis and is_whole else origin.place
            graphs.setdefault(Problem(place, what, hint), []).extend(names)
        return [
            *said,
            *(
                Problem(p.place, f"in {listed(list(dict.fromkeys(names)))}: {p.what}", p.hint)
                for p, names in graphs.items()
            ),
        ]

    def _common_choice(self, where: Mapping[str, Sequence[Variant]]) -> Origin | None:
        """Return the choice that all variants with a problem have in common, None if it is not for a choice."""
        if all(len(variants) == self._seen[graph] for graph, variants in where.items()):
            return None
        variants = [variant for found in where.values() for variant in found]
        common = [
            Origin(choice.place, axis.name, choice.label)
            for axis in self._axes.values()
            for choice in reversed(axis.choices)
            if all(variant.choices[axis.name] is choice for variant in variants)
        ]
        bases = {(axis.name, axis.choices[0].label) for axis in self._axes.values()}
        return next((o for o in common if (o.axis, o.choice) not in bases), common[0] if common else None)


def _in_one_choice(hint: str) -> str:
    """Return the advice of a swap for a study, where ``--set`` would change the other variants, too."""
    head, option, rest = hint.partition(f"choose with {SET} ")
    return f"{head}write a choice that sets this, too: {rest.replace(f'{SET} ', '')}" if option else hint


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them, at most three."""
    if len(names) > 4:
        return f"{', '.join(names[:3])} and {len(names) - 3} more"
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
