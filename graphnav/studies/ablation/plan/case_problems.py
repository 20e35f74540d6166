"""Collect the problems of all cases of a study, and report each once, at its place in the study."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from graphnav.core.errors import Hint, Place, Problem, ProblemKind, Suggestion, UserError
from graphnav.studies.ablation.plan.variants import Variant
from graphnav.studies.ablation.study import Axis


@dataclass(frozen=True)
class Origin:
    """The location of an override of a case: in a choice of an axis, or for all runs (both empty)."""

    place: Place | None
    axis: str = ""
    choice: str = ""


@dataclass(frozen=True)
class _Finding:
    """A problem with an override, or with a choice, of the study."""

    origin: Origin
    what: str
    hint: Hint
    kind: ProblemKind

    def at(self, place: Place | None, prefix: str = "") -> Problem:
        """Return it as a problem at a place."""
        return Problem(place, prefix + self.what, self.hint, self.kind)


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

    def add(self, graph: str, variant: Variant, error: UserError, origins: Mapping[Place, Origin]) -> None:
        """Add what is wrong with a case; ``origins``: of its overrides, by place."""
        for problem in dict.fromkeys(error.problems):
            finding = origins.get(problem.place) if problem.place else None, problem
            self._found.setdefault(finding, {}).setdefault(graph, []).append(variant)

    def problems(self) -> list[Problem]:
        """Return what is wrong: what all choices of an axis have at the axis, all else where it was written.

        What is wrong with a graph, but only with some variants, is reported at the choice that they have in common.
        """
        of_graphs: dict[Problem, None] = {}
        found: dict[_Finding, list[str]] = {}
        for (origin, problem), where in self._found.items():
            by = origin or self._common_choice(where)
            if by is None:
                of_graphs[problem] = None
            else:
                hint = _in_one_choice(problem) if by.axis else problem.hint
                found.setdefault(_Finding(by, problem.what, hint, problem.kind), []).extend(where)
        graphs: dict[tuple[Place | None, _Finding], list[str]] = {}
        for finding, names in found.items():
            place = self._place(finding, found)
            graphs.setdefault((place, replace(finding, origin=Origin(None))), []).extend(names)
        return [
            *of_graphs,
            *(
                finding.at(place, f"in {listed(list(dict.fromkeys(names)))}: ")
                for (place, finding), names in graphs.items()
            ),
        ]

    def _place(self, finding: _Finding, found: Iterable[_Finding]) -> Place | None:
        """Return the place of a finding: that of its axis where all choices of the axis have it."""
        axis = self._axes.get(finding.origin.axis)
        if axis is None:
            return finding.origin.place
        alike = (f for f in found if f.origin.axis == axis.name and f.at(None) == finding.at(None))
        choices = {one.origin.choice for one in alike}
        return axis.place if 1 < len(axis.choices) == len(choices) else finding.origin.place

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


def _in_one_choice(problem: Problem) -> Hint:
    """Return the advice for one choice of an axis, where ``--set`` would change the other variants, too."""
    if problem.kind == "ambiguous" and isinstance(problem.hint, Suggestion):
        names = problem.hint.names
        return Suggestion(names, f"write a choice that sets this, too: {' or '.join(names)}")
    return problem.hint


def listed(names: Sequence[str]) -> str:
    """Return names as a sentence lists them, at most three."""
    if len(names) > 4:
        return f"{', '.join(names[:3])} and {len(names) - 3} more"
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
