"""Some stages of a checked graph, written so that another process makes them without the others."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from pathlib import Path

from graphnav.core.catalog import Catalog
from graphnav.core.errors import UserError
from graphnav.core.graph.check import classes_of
from graphnav.core.graph.graph import Graph
from graphnav.core.graph.node import Channel, Input, Node
from graphnav.core.graph.resolved import resolved_yaml
from graphnav.core.graph.wiring.settings import run_options, settings_of
from graphnav.core.spec import Spec, StageSpec, parse_spec, parse_yaml
from graphnav.core.stage import Port, ports_of


def part_yaml(graph: Graph, stages: Collection[str]) -> str:
    """Return some stages of a graph with all that they are made of, for `part_of`; paths hold in any folder."""
    nodes = tuple(node for node in graph.nodes if node.name in stages)
    alone = replace(graph, nodes=nodes, inputs={}, outputs={}, queues={}, deploy={})
    return resolved_yaml(alone, portable_paths=False)


def part_of(text: str, path: Path, catalog: Catalog, *, loads_plugins: bool = True) -> Graph:
    """Return the graph of what `part_yaml` wrote: its stages alone, in the graph's order, with all of their wires.

    Only their families and the one-file plugins are loaded, these not without ``loads_plugins``: then the catalog has
    them. ``path``: the graph's file, which is not read.

    Raises
    ------
    UserError
        A stage is not as it was where the text was written: its package or the files of its parameters have changed.
    """
    value, problems = parse_yaml(text.encode(), str(path))
    if loads_plugins:
        plugins = value.plain().get("plugins", ()) if not problems else ()
        catalog.add_files(map(Path, plugins))
    spec, more = parse_spec(value)
    problems += more
    classes = classes_of(spec, catalog, problems)
    nodes = tuple(
        Node(
            name,
            spec.stages[name].use,
            cls,
            settings_of(spec.stages[name], cls, path.parent, problems),
            tuple(_input(spec, spec.stages[name], port) for port in ports_of(cls).inputs),
            {port.name: _channel(spec, f"{name}.{port.name}", port) for port in ports_of(cls).outputs},
            spec.stages[name].place,
        )
        for name, cls in classes.items()
    )
    run = run_options(spec.run, problems)
    if problems:
        raise UserError(problems)
    order = tuple(node for node in nodes if not node.is_source)
    return Graph(path, spec.about, nodes, order, {c.ref: c for node in nodes for c in node.outputs.values()}, run)


def _input(spec: Spec, stage: StageSpec, port: Port) -> Input:
    wire = stage.wires.get(port.name)
    return Input(port, None if wire is None else _channel(spec, str(wire.value.data), port))


def _channel(spec: Spec, ref: str, port: Port) -> Channel:
    """Return a channel: readers and writers of it have the same message type."""
    renamed = spec.channels.get(ref)
    return Channel(ref, ref if renamed is None else str(renamed.value.data), port.message)
