"""Load the graph of every case, and report what is wrong with any."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from graphnav import Graph, Place, Problem, Role, Stage, Suggestion, UserError
from graphnav.core.catalog import Catalog
from graphnav.core.errors import Hint, ProblemKind
from graphnav.core.graph import Node, Override, ReadGraph, has_path, read_graph
from graphnav.core.stage import params_of
from graphnav.studies.ablation.plan.upstream import driving_stages
from graphnav.studies.ablation.plan.variants import Variant
from graphnav.studies.ablation.study import Axis, Study


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


@dataclass(frozen=True)
class CheckedCase:
    """A graph with a variant: nothing is wrong with it."""

    name: str
    """As the study names the graph."""
    variant: Variant
    overrides: tuple[Override, ...]
    """Paths as they were found."""
    graph: Graph

    @cached_property
    def driving(self) -> frozenset[str]:
        """The stages that drive, as of `driving_stages`."""
        return driving_stages(self.graph)

    @cached_property
    def parts(self) -> dict[str, tuple[object, ...]]:
        """The parts of each stage (`stage_parts`), by its name."""
        return {node.name: stage_parts(node.use, node.params) for node in self.graph.nodes}

    @cached_property
    def _made_of(self) -> dict[str, tuple[object, ...]]:
        """Use, parameters and wires of each stage, by its name."""
        return {node.name: (node.name, *self.parts[node.name], *_wires(node)) for node in self.graph.nodes}

    @property
    def identity(self) -> object:
        """Key of its runs: equal for graphs that do the same, whatever was swapped and pruned on the way."""
        return self.name, self.identity_of({node.name for node in self.graph.nodes}), repr(self.graph.run)

    @property
    def uses(self) -> dict[str, str]:
        """The ``use`` of every stage."""
        return {node.name: node.use for node in self.graph.nodes}

    @property
    def swapped(self) -> frozenset[str]:
        """The stages that its axes put in."""
        return frozenset(_swaps(self.variant.overrides))

    def roles_of(self, stages: Collection[str]) -> frozenset[Role]:
        """Return the roles of stages; those that the graph does not have count for nothing."""
        return frozenset(node.stage_class.role for node in self.graph.nodes if node.name in stages)

    def identity_of(self, stages: Collection[str]) -> object:
        """Return a key of stages and of all sources, equal for cases in which these do the same."""
        return self._of({*stages, *(source.name for source in self.graph.sources)})

    @property
    def drive(self) -> object:
        """A key of what drives and of the sources, equal for cases that meet the same frames.

        Parameters of sources that only change outputs which nothing that drives reads (`Param.changes`) do not count.
        """
        driving = self.driving
        read = {i.channel.ref for node in self.graph.nodes if node.name in driving for i in node.inputs if i.channel}
        sources = tuple(
            (source.name, *stage_parts(source.use, _params_that_drive(source, read)), *_wires(source))
            for source in self.graph.sources
        )
        return self.name, self._of(driving), sources, self.graph.run.until_s

    def _of(self, stages: Collection[str]) -> tuple[object, ...]:
        return tuple(made for name, made in self._made_of.items() if name in stages)

    @property
    def notices(self) -> tuple[str, ...]:
        """Notices of swaps; a swap for the same stage did nothing and has none."""
        idle = {f"{stage}: it is {use} already" for stage, use in _swaps(self.overrides).items()}
        return tuple(notice for notice in self.graph.notices if notice not in idle)


def check_cases(
    study: Study, variants: tuple[Variant, ...], catalog: Catalog, problems: CaseProblems
) -> list[CheckedCase]:
    """Return every graph with every variant, in this order; what is wrong with some is added to ``problems``."""
    fine: set[object] = set()
    checked = []
    for name in study.graphs:
        read = _read(name, catalog)
        for variant in variants:
            origins = _origins(study, variant)
            problems.count_case(name)
            try:
                case = _load(study, name, variant, read)
                new = {part: node for node in case.graph.nodes if (part := case.parts[node.name]) not in fine}
                replace(case.graph, nodes=tuple(new.values())).make_stages()
                fine |= new.keys()
                checked.append(case)
            except UserError as error:
                problems.add(name, variant, error, origins)
    return checked


def _read(name: str, catalog: Catalog) -> ReadGraph | UserError:
    """Return a graph, read once for all variants, or what each of them is to report."""
    try:
        return read_graph(name, catalog)
    except UserError as error:
        return error


def _load(study: Study, name: str, variant: Variant, read: ReadGraph | UserError) -> CheckedCase:
    of_all = study.overrides
    if study.decomposition is not None:
        of_all = Override.without_replaced(of_all, variant.overrides)
    overrides = (*of_all, *variant.overrides)
    if isinstance(read, UserError):
        raise read
    graph = read.variant(overrides)
    _refuse_live(graph)
    nodes = {node.name: node for node in graph.nodes}
    return CheckedCase(name, variant, tuple(_as_found(override, nodes) for override in overrides), graph)


def _as_found(override: Override, nodes: Mapping[str, Node]) -> Override:
    """Return an override whose paths are absolute where they were found beside the study."""
    for target in override.target.each if override.target.kind == "setting" and override.folder else ():
        node = nodes.get(target.stages[0])
        if node is not None and target.key in node.settings and has_path(params_of(node.stage_class)[target.key].type):
            return replace(override, value=node.settings[target.key].written)
    return override


def _origins(study: Study, variant: Variant) -> dict[Place, Origin]:
    """Return the origin of every override of a case, by its place."""
    origins = {override.place: Origin(_shown(override.place)) for override in study.overrides}
    for axis, choice in variant.choices.items():
        origins |= {o.place: Origin(_shown(o.place), axis, choice.label) for o in choice.overrides}
    return origins


def _shown(place: Place) -> Place:
    """Return a place without the number of a value in an option."""
    return place if place.line else place._replace(column=0)


def _swaps(overrides: Iterable[Override]) -> dict[str, str]:
    """Return which stages are swapped or added, and for what."""
    return {stage: str(o.value) for o in overrides if o.target.is_stage for stage in o.target.stages}


def stage_parts(use: str, params: Mapping[str, object]) -> tuple[object, ...]:
    """Return what a stage is made of; that of the same name and parameters passes the same checks."""
    return use, repr(list(params.items()))


def _params_that_drive(source: Node, read: Collection[str]) -> dict[str, object]:
    """Return the parameters of a source that may change a drive; ``read``: the outputs that this reads."""
    ports = {port for port, channel in source.outputs.items() if channel.ref in read}
    declared = params_of(source.stage_class)
    unread = {name for name in source.params if declared[name].changes and ports.isdisjoint(declared[name].changes)}
    return {name: value for name, value in source.params.items() if name not in unread}


def _wires(node: Node) -> tuple[object, ...]:
    reads = ((i.port.name, i.channel.ref if i.channel else "") for i in node.inputs)
    return *reads, *(channel.name for channel in node.outputs.values())


def _refuse_live(graph: Graph) -> None:
    """Raise UserError for a graph whose messages come from elsewhere, at the wall clock's pace."""
    for given in graph.inputs.values():
        raise UserError.of(
            f"the input '{given.channel.ref}' makes this graph live, but a study runs in simulated time",
            "name a graph whose images come from a world, a video or a folder of images",
            given.place,
        )
    for node in graph.sources:
        if node.is_live_source:
            raise UserError.of(
                f"stage '{node.name}' ({node.use}) takes what a device delivers, but a study runs in simulated time",
                "name a graph whose images come from a world, a video or a folder of images",
                node.place,
            )


def stage_classes(cases: list[CheckedCase]) -> dict[str, list[type[Stage]]]:
    """Return what the stages of all cases are, by name."""
    found: dict[str, list[type[Stage]]] = {}
    for case in cases:
        for node in case.graph.nodes:
            if node.stage_class not in found.setdefault(node.name, []):
                found[node.name].append(node.stage_class)
    return found
