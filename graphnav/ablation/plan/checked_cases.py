"""Check the graph of every case of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from graphnav.ablation.plan.case_problems import CaseProblems, Origin
from graphnav.ablation.plan.resolve_paths import resolve_paths
from graphnav.ablation.plan.variants import Variant
from graphnav.ablation.study import Study, swaps_of
from graphnav.catalog import Catalog
from graphnav.errors import UserError
from graphnav.graph import Graph, Node, load_graph
from graphnav.stage import Role, Stage

_ROLES: tuple[Role, ...] = ("oracle", "baseline", "method")
"""The most special one first."""
_FROM_COMMAND = "--"


@dataclass(frozen=True)
class CheckedCase:
    """A graph with a variant: nothing is wrong with it."""

    name: str
    """As the study names the graph."""
    variant: Variant
    sets: tuple[str, ...]
    graph: Graph

    @property
    def identity(self) -> object:
        """What makes its runs: equal for graphs that do the same, whatever was swapped and pruned on the way."""
        nodes = tuple((node.name, *_made_of(node.use, node.params), *_wires(node)) for node in self.graph.nodes)
        return self.name, nodes, repr(self.graph.run)

    @property
    def uses(self) -> dict[str, str]:
        """The ``use`` of every stage."""
        return {node.name: node.use for node in self.graph.nodes}

    @property
    def role(self) -> Role:
        """The most special role that its axes put in."""
        swapped = swaps_of(self.variant.sets)
        roles = {node.stage_class.role for node in self.graph.nodes if node.name in swapped}
        return next((role for role in _ROLES if role in roles), "method")

    @property
    def notices(self) -> tuple[str, ...]:
        """Notices of swaps; a swap for the same stage did nothing and has none."""
        idle = {f"{stage}: it is {use} already" for stage, use in swaps_of(self.sets).items()}
        return tuple(notice for notice in self.graph.notices if notice not in idle)


def check_cases(
    study: Study, variants: tuple[Variant, ...], catalog: Catalog, problems: CaseProblems
) -> list[CheckedCase]:
    """Return every graph with every variant, in this order; what is wrong with some is added to ``problems``."""
    fine: set[object] = set()
    checked = []
    for name in study.graphs:
        for variant in variants:
            origins = _origins(study, variant)
            problems.count_case(name)
            try:
                case = _load(study, name, variant, origins, catalog)
                new = {part: node for node in case.graph.nodes if (part := _made_of(node.use, node.params)) not in fine}
                replace(case.graph, nodes=tuple(new.values())).make_stages()
                fine |= new.keys()
                checked.append(case)
            except UserError as error:
                problems.add(name, variant, error, origins)
    return checked


def _load(study: Study, name: str, variant: Variant, origins: dict[str, Origin], catalog: Catalog) -> CheckedCase:
    sets = tuple(origins)
    graph = load_graph(name, catalog, sets)
    if study.folder is not None:
        moved = {
            text: resolve_paths(graph, text, study.folder)
            for text, origin in origins.items()
            if origin.place is not None and not origin.place.file.startswith(_FROM_COMMAND)
        }
        if any(text != here for text, here in moved.items()):
            origins |= {here: origins[text] for text, here in moved.items()}
            sets = tuple(moved.get(text, text) for text in sets)
            graph = load_graph(name, catalog, sets)
    _refuse_live(graph)
    return CheckedCase(name, variant, sets, graph)


def _origins(study: Study, variant: Variant) -> dict[str, Origin]:
    """Return the ``--set`` texts of a case, each with its origin."""
    origins = {text: Origin(study.places.get(text)) for text in study.sets}
    for axis, choice in variant.choices.items():
        origins |= {text: Origin(place, axis, choice.label) for text, place in choice.placed_sets}
    return origins


def _made_of(use: str, params: Mapping[str, object]) -> tuple[object, ...]:
    """Return what a stage is made of; that of the same name and parameters passes the same checks."""
    return use, *((name, repr(value)) for name, value in params.items())


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


def stage_classes(cases: list[CheckedCase]) -> dict[str, list[type[Stage]]]:
    """Return what the stages of all cases are, by name."""
    found: dict[str, list[type[Stage]]] = {}
    for case in cases:
        for node in case.graph.nodes:
            if node.stage_class not in found.setdefault(node.name, []):
                found[node.name].append(node.stage_class)
    return found
