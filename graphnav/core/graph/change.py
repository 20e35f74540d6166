"""Change stages of a checked graph while it runs: what the rest of the graph allows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Problem, UserError, did_you_mean
from graphnav.core.graph.graph import Graph
from graphnav.core.graph.load import graph_of
from graphnav.core.graph.node import Node
from graphnav.core.graph.overrides.override import Override
from graphnav.core.graph.resolved import resolved_yaml
from graphnav.core.spec import TIME_KEYS

_SOURCE = "graph of the run"
"""Location of errors in what the graph said before: its file need not say that any more."""
_STOP = "stop the run, and start it with this change"


class GraphChange(NamedTuple):
    """A change of a running graph that can be made: the ``graph`` from then on, and its stages that are rebuilt."""

    graph: Graph
    nodes: tuple[Node, ...]
    words: tuple[str, ...]
    """The request, as ``--set`` takes it."""
    notices: tuple[str, ...] = ()
    """Changes of parameters and wires that follow."""


def changed_graph(graph: Graph, began: Graph, overrides: Sequence[Override], catalog: Catalog) -> GraphChange:
    """Return a running graph with swaps, parameters, and wires of swapped stages that were asked for.

    ``began``: the graph with which the run began. Stages that nothing reads any more stay.

    Raises
    ------
    UserError
        What is wrong with it, as where the graph is loaded; or it changes more than the stages that it names, or what
        only the start of a run can change.
    """
    problems = list(_refused(overrides))
    if problems:
        raise UserError(problems)
    text = resolved_yaml(graph, portable_paths=False)
    replaced = [path.name for path in graph.plugins]
    new = graph_of(text.encode(), graph.path, catalog, overrides, _SOURCE, replaced, prunes=False)
    causes = {stage: override for override in overrides for stage in override.target.stages}
    nodes = tuple(new.node(name) for name in causes)
    problems += _source_problems(graph, nodes, causes)
    problems += _effects(graph, new, causes)
    problems += [problem for node in nodes for problem in _unpublished(node, began, causes[node.name])]
    if problems:
        raise UserError(problems)
    notices = tuple(notice for notice in new.notices if notice not in graph.notices)
    return GraphChange(graph.with_nodes(nodes), nodes, tuple(override.words for override in overrides), notices)


def restarted_graph(graph: Graph, stage: str) -> GraphChange:
    """Return a running graph in which one stage is rebuilt as it is.

    Raises
    ------
    UserError
        No stage has this name, or it is a source.
    """
    names = [node.name for node in graph.nodes]
    if stage not in names:
        hint = did_you_mean(stage, names) or f"stages are {', '.join(names)}"
        raise UserError(Problem(None, f"there is no stage '{stage}'", hint, "unknown"))
    node = graph.node(stage)
    if node.is_source:
        raise UserError.of(_source_told(node), "stop the run, and start it again")
    return GraphChange(graph, (node,), ())


def _refused(overrides: Sequence[Override]) -> Iterator[Problem]:
    """Yield what no running graph can take over, whatever it is."""
    swapped = {stage for override in overrides if override.target.kind == "stage" for stage in override.target.stages}
    for override in overrides:
        target = override.target
        if target.kind == "run":
            yield Problem(override.place, f"'{target}' holds for the entire run", _STOP)
        elif target.kind == "add":
            yield Problem(override.place, "no stage can be added to a running graph", _STOP)
        elif target.kind == "setting" and target.key in TIME_KEYS:
            yield Problem(override.place, f"'{target.key}' is not a parameter: it holds for the entire run", _STOP)
        elif target.kind == "wire" and not swapped.issuperset(target.stages):
            what = "a running graph keeps its wires, except those of the stages that are swapped"
            yield Problem(override.place, what, "add it to the swap of this stage: graphnav swap ... --set ...")


def _source_told(node: Node) -> str:
    return f"stage '{node.name}' ({node.use}) is a source: a running graph keeps what its time comes from"


def _source_problems(graph: Graph, nodes: Sequence[Node], causes: dict[str, Override]) -> Iterator[Problem]:
    for node in nodes:
        for one in (graph.node(node.name), node):
            if one.is_source:
                yield Problem(causes[node.name].place, _source_told(one), _STOP)
                break


def _effects(graph: Graph, new: Graph, causes: dict[str, Override]) -> Iterator[Problem]:
    """Yield what else a change would change: the wires of other stages, and what leaves the run."""
    swaps = [override for override in causes.values() if override.target.kind == "stage"]
    place = (swaps or list(causes.values()))[0].place
    for node in graph.nodes:
        if node.name in causes:
            continue
        same = new.node(node.name).same_inputs(node)
        for i in node.inputs:
            if i.port.name not in same and i.channel is not None:
                what = f"input '{i.port.name}' of stage '{node.name}' ({node.use}) reads {i.channel.ref}, which is gone"
                hint = "a running graph keeps the wires of all other stages: choose a stage with the same outputs"
                yield Problem(place, what, hint)
    for ref in graph.outputs:
        if ref not in new.outputs:
            what = f"{ref} leaves the run, and the new stage does not publish it"
            yield Problem(place, what, "choose a stage with the same outputs")


def _unpublished(node: Node, began: Graph, cause: Override) -> Iterator[Problem]:
    """Yield the inputs of a stage that read what is left out because nothing read it when the run began."""
    for i in node.inputs:
        if i.channel is None or i.channel.ref in began.read or i.channel.ref in began.inputs:
            continue
        writer = began.node(i.channel.stage)
        port = next((port for port in writer.output_ports if port.name == i.channel.port), None)
        if port is not None and port.optional:
            what = (
                f"input '{i.port.name}' of stage '{node.name}' ({node.use}) reads {i.channel.ref}, which "
                f"'{writer.name}' leaves out, because no stage read it when the run began"
            )
            yield Problem(cause.place, what, _STOP)
