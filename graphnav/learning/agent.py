"""The stage that stands for an agent in a graph, and the graph that has it in place of another stage."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from graphnav import Graph, Message, Role, Stage
from graphnav.core.graph import Channel, Input, Node
from graphnav.core.stage import ports_of
from graphnav.learning.interface import Interface

FILE = "agent.py"
_USE = "agent.agent"


class Agent(Stage):
    """The base of agents: a step publishes what `answer` holds, which the agent gave since the step before."""

    is_agent: ClassVar[bool] = True

    answer: ClassVar[Message | None] = None

    def step(self) -> None:
        """Publish the answer."""


def agent_class(interface: Interface) -> type[Stage]:
    """Return the class of the agent's stage, whose ports are those of its interface."""
    port, message = interface.acts.port, interface.acts.message
    outputs = _outputs_of(port, message)

    def step(self: Any, **_inputs: Any) -> Any:
        return outputs(self.answer)

    names = [one.port for one in interface.observed]
    parameters = [inspect.Parameter("self", inspect.Parameter.POSITIONAL_OR_KEYWORD)]
    parameters += [inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in names]
    vars(step)["__signature__"] = inspect.Signature(parameters)
    step.__annotations__ = {**{one.port: one.kind for one in interface.observed}, "return": outputs}
    role: Role = "oracle" if interface.sees_truth else "method"
    return type("Agent", (Agent,), {"__module__": __name__, "step": step, "role": role})


def _outputs_of(port: str, message: type[Message]) -> Any:
    """Return the NamedTuple of one output."""
    return NamedTuple("AgentOutputs", [(port, message)])


def agent_source(interface: Interface) -> str:
    """Return the agent's stage as a one-file plugin, with which the run folder of an episode loads again."""
    messages = list(dict.fromkeys([interface.acts.message, *(one.channel.message for one in interface.observed)]))
    names = {message: f"_{place}" for place, message in enumerate(messages)}
    imports = [f"from {message.__module__} import {message.__name__} as {name}" for message, name in names.items()]
    kinds = {one.port: names[one.channel.message] for one in interface.observed}
    inputs = [
        f"{one.port}: {f'Latest[{kinds[one.port]}]' if one.sampled else kinds[one.port]}" for one in interface.observed
    ]
    role = "oracle" if interface.sees_truth else "method"
    return "\n".join(
        [
            '"""The agent of this episode: what it did is in the log, and a replay plays it."""',
            "",
            "from typing import NamedTuple",
            "",
            "from graphnav import Latest, Stage, hookimpl",
            *imports,
            "",
            "",
            "class AgentOutputs(NamedTuple):",
            f"    {interface.acts.port}: {names[interface.acts.message]}",
            "",
            "",
            "class Agent(Stage):",
            '    """An agent outside of the graph."""',
            "",
            f'    role = "{role}"',
            "    is_agent = True",
            "",
            f"    def step(self, {', '.join(inputs)}) -> AgentOutputs:",
            '        raise RuntimeError("the agent of an episode is not part of its graph: put a policy in its place")',
            "",
            "",
            "@hookimpl",
            "def graphnav_stages() -> list[type[Stage]]:",
            "    return [Agent]",
            "",
        ]
    )


def graph_with_agent(
    graph: Graph, interface: Interface, wanted: Collection[str], *, skips: bool, plugin: Path | None
) -> Graph:
    """Return the graph with an agent in place of the stage whose channel it writes.

    ``wanted``: stages that are needed besides the world, the agent and what feeds them. ``skips``: whether to leave out
    stages that nothing needs; scores stay whose inputs are published without them. ``plugin``: the agent's file.
    """
    name = interface.acts.stage
    cls = agent_class(interface)
    channels = {one.port: one.channel for one in interface.observed}
    agent = Node(
        name,
        _USE,
        cls,
        {},
        tuple(Input(port, channels[port.name]) for port in ports_of(cls).inputs),
        {interface.acts.port: interface.acts},
        graph.node(name).place,
    )
    nodes = tuple(agent if node.name == name else _without(node, name, interface.acts) for node in graph.nodes)
    kept = _needed(nodes, {name, *wanted}) if skips else {node.name for node in nodes}
    by_name = {node.name: node for node in nodes if node.name in kept}
    order = [node.name for node in graph.order if node.name in kept]
    if any(order.index(writer) > order.index(name) for writer in agent.writers if writer in order):
        changed = replace(graph, nodes=tuple(by_name.values())).with_nodes([agent])
        order = [node.name for node in changed.order]
    written = {ref for node in by_name.values() for ref in (channel.ref for channel in node.outputs.values())}
    return replace(
        graph,
        nodes=tuple(by_name.values()),
        order=tuple(by_name[one] for one in order),
        channels={ref: channel for ref, channel in graph.channels.items() if ref in written},
        outputs={},
        queues={},
        deploy={},
        plugins=(*graph.plugins, *([] if plugin is None else [plugin])),
    )


def _without(node: Node, stage: str, kept: Channel) -> Node:
    """Return a node that no longer samples other channels of a stage than one."""
    inputs = tuple(
        replace(i, channel=None) if i.channel is not None and i.channel.stage == stage and i.channel != kept else i
        for i in node.inputs
    )
    return replace(node, inputs=inputs)


def _needed(nodes: Iterable[Node], wanted: Collection[str]) -> set[str]:
    """Return the stages that sources and those ``wanted`` need, and the scores that need nothing else."""
    by_name = {node.name: node for node in nodes}
    found, waiting = set[str](), [*wanted, *(node.name for node in by_name.values() if node.is_source)]
    while waiting:
        if (name := waiting.pop()) not in found:
            found.add(name)
            waiting += _read_by(by_name[name])
    published = {channel.ref for channel in _published(by_name.values(), found)}
    for node in by_name.values():
        read = {i.channel.ref for i in node.inputs if i.channel is not None}
        if node.stage_class.role == "score" and read <= published:
            found.add(node.name)
    return found


def _read_by(node: Node) -> list[str]:
    return [i.channel.stage for i in node.inputs if i.channel is not None]


def _published(nodes: Iterable[Node], found: Collection[str]) -> Iterator[Channel]:
    """Yield the channels that stages publish anyway: what one of them reads, and what none may leave out."""
    read = {i.channel for node in nodes if node.name in found for i in node.inputs if i.channel is not None}
    for node in nodes:
        if node.name in found:
            costly = _costly(node)
            yield from (c for port, c in node.outputs.items() if c in read or not costly(port))


def _costly(node: Node) -> Callable[[str], bool]:
    """Return whether a port of a stage costs time that is spared where nothing reads it."""
    if node.is_source:
        made_again = {channel.port for channel in node.reproducible}
        return lambda port: port in made_again
    optional = {port.name for port in node.output_ports if port.optional}
    return lambda port: port in optional
