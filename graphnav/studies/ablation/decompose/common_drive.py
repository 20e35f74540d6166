"""Let an oracle drive, whatever the stages that are measured do."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Place
from graphnav.core.graph import Graph, Override, Target, load_graph, without_replaced
from graphnav.core.messages import Message
from graphnav.core.stage import ports_of
from graphnav.studies.ablation.plan import driving_stages

_PREFIX = "oracle_"


def common_drive(
    name: str, overrides: tuple[Override, ...], oracles: Mapping[str, str], catalog: Catalog, place: Place
) -> tuple[Override, ...] | None:
    """Return what lets the last stage's oracle drive a graph, the same for all variants; None if that cannot be.

    What still reads one of the other stages and drives, as a guard does, gets an oracle of its own in their place.
    """
    *others, last = oracles
    found = [Override(Target("stage", (last,)), oracles[last], place)]
    graph = load_graph(name, catalog, (*without_replaced(overrides, found), *found))
    added: dict[str, None] = {}
    for stage, port, read, message in _reads(graph, set(others)):
        if (output := _output(catalog, oracles[read], message)) is None:
            return None
        added[read] = None
        found.append(Override(Target("wire", (stage,), port), f"{_PREFIX}{read}.{output}", place))
    found += [Override(Target("add", (f"{_PREFIX}{read}",)), oracles[read], place) for read in added]
    graph = load_graph(name, catalog, (*without_replaced(overrides, found), *found))
    return tuple(found) if driving_stages(graph).isdisjoint(others) else None


def _reads(graph: Graph, stages: set[str]) -> Iterator[tuple[str, str, str, type[Message]]]:
    """Yield who reads what of some stages and drives: stage, port, the stage that is read, the message."""
    driving = driving_stages(graph)
    for node in graph.nodes:
        for i in node.inputs if node.name in driving - stages else ():
            if i.channel is not None and i.channel.stage in stages:
                yield node.name, i.port.name, i.channel.stage, i.channel.message


def _output(catalog: Catalog, use: str, message: type[Message]) -> str | None:
    """Return the one output of a stage that carries a message, None if there is not exactly one."""
    names = [port.name for port in ports_of(catalog.stage(use)).outputs if port.message is message]
    return names[0] if len(names) == 1 else None
