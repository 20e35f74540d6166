"""The rivals of a tuning, and what is searched of each."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graphnav import Graph, Place, Problem, UserError, did_you_mean
from graphnav.core.graph import Node, Override
from graphnav.core.stage import Param, params_of
from graphnav.studies.ablation.plan import CheckedStudy
from graphnav.studies.ablation.study import Study
from graphnav.studies.tuning.search_range import SearchRange, fitted, parts_of, range_of

_NUMBERS = (int, float)


@dataclass(frozen=True)
class Rival:
    """One choice of the axis."""

    label: str
    overrides: tuple[Override, ...]
    space: tuple[SearchRange, ...]
    center: Mapping[str, Any]
    """The values that the graph and the stages' defaults give to what is searched, by ``stage.parameter``."""
    left: tuple[str, ...]
    """Numbers that are not searched, because nothing says what they could be."""


def rivals_of(study: Study, checked: CheckedStudy, searches: Sequence[SearchRange]) -> tuple[Rival, ...]:
    """Return the rivals of a study with one axis.

    Searched are the parameters of the stages that the axis swaps, or else of those whose parameters it sets, in every
    rival alike; not those that the rival or the study sets. ``searches`` replace and add ranges.

    Raises
    ------
    UserError
        No rival has a parameter that ``searches`` name, or may have the values that they name, or it is set already.
    """
    [axis] = study.axes
    stages = _stages(study)
    fixed = {str(one) for override in study.overrides for one in override.target.each}
    rivals = []
    for choice in axis.choices:
        graphs = graphs_of(checked, choice.label)
        own = {str(one) for override in choice.overrides for one in override.target.each}
        rivals.append(_rival(choice.label, choice.overrides, graphs, stages, fixed | own, searches))
    if wrong := [*_unknown(searches, rivals), *_fixed(searches, study)]:
        raise UserError(wrong)
    return tuple(rivals)


def _rival(
    label: str,
    overrides: tuple[Override, ...],
    graphs: Sequence[Graph],
    stages: Sequence[tuple[str, ...]],
    fixed: set[str],
    searches: Sequence[SearchRange],
) -> Rival:
    space: dict[str, SearchRange] = {}
    center: dict[str, Any] = {}
    left = []
    wanted = {search.target: search for search in searches}
    taken = fixed.union(*(search.parts for search in searches))
    for target, param, values in _parameters(graphs, stages, wanted):
        if target in wanted:
            space[target], center[target] = fitted(wanted[target], param), values[0]
        elif taken.isdisjoint(parts_of(target)):
            taken |= parts_of(target)
            found = range_of(target, param, values[0]) if all(value == values[0] for value in values) else None
            if found is not None:
                space[target], center[target] = found, values[0]
            elif isinstance(values[0], _NUMBERS):
                left.append(target)
    return Rival(label, overrides, tuple(space.values()), center, tuple(left))


def _parameters(
    graphs: Sequence[Graph], stages: Sequence[tuple[str, ...]], wanted: Mapping[str, SearchRange]
) -> Iterator[tuple[str, Param, list[Any]]]:
    """Yield what could be searched, its declaration, and its value in each graph."""
    named = [tuple(target.rpartition(".")[0].split(",")) for target in wanted]
    for group in dict.fromkeys([*stages, *named]):
        nodes = [node for graph in graphs if (node := _node(graph, group[0])) is not None]
        if len(nodes) < len(graphs) or any(node.stage_class is not nodes[0].stage_class for node in nodes):
            continue
        for name, param in params_of(nodes[0].stage_class).items():
            target = f"{','.join(group)}.{name}"
            if group in stages or target in wanted:
                yield target, param, [node.params[name] for node in nodes]


def _node(graph: Graph, stage: str) -> Node | None:
    return next((node for node in graph.nodes if node.name == stage), None)


def graphs_of(checked: CheckedStudy, label: str) -> list[Graph]:
    """Return the graphs of a rival, one of each that the study names."""
    cases = {(case.graph, case.variant): case for case in checked.plan.cases}
    return [checked.graphs[cases[graph, label].folder] for graph in checked.plan.graphs]


def _stages(study: Study) -> tuple[tuple[str, ...], ...]:
    """Return the stages that the axis swaps, else those whose parameters it sets; several that are set at once."""
    targets = [override.target for choice in study.axes[0].choices for override in choice.overrides]
    swapped = [target.stages for target in targets if target.is_stage]
    return tuple(dict.fromkeys(swapped or [target.stages for target in targets if target.kind == "setting"]))


def _unknown(searches: Sequence[SearchRange], rivals: Sequence[Rival]) -> Iterator[Problem]:
    known = {target for rival in rivals for target in rival.center}
    for search in searches:
        if search.target not in known:
            hint = did_you_mean(search.target, known) or "graphnav stages STAGE lists the parameters of a stage"
            what = f"no rival has the parameter '{search.target}'"
            yield Problem(Place(f"--search {search.text}"), what, hint)


def _fixed(searches: Sequence[SearchRange], study: Study) -> Iterator[Problem]:
    """Yield the searched parameters that the study or a rival sets: every trial would be refused."""
    overrides = [*study.overrides, *(override for choice in study.axes[0].choices for override in choice.overrides)]
    for search in searches:
        place = Place(f"--search {search.text}")
        sets = (one for one in overrides if search.parts & {str(each) for each in one.target.each})
        if found := next(sets, None):
            what = f"'{search.target}' is searched, but {found.place} sets it"
            yield Problem(place, what, "keep one of the two")
