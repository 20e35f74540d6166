"""The boxes of a drawing: stages, what comes in from other programs, what leaves for them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from graphnav.graph import Channel, Graph, InputChannel, Node, OutputChannel

Kind = Literal["source", "stage", "input", "output"]


@dataclass(frozen=True)
class InPort:
    """An input port as drawings show it."""

    name: str
    channel: Channel | None
    is_sampled: bool = False
    reading: str = ""
    """How it is read where that is not plain: "latest" or "since"."""


@dataclass(frozen=True)
class OutPort:
    """An output port as drawings show it."""

    name: str
    channel: Channel
    alias: str = ""
    """Its LCM channel, or the log that it is read from, where that is not its own name."""


@dataclass(frozen=True)
class Box:
    """One box: ``key`` is its own among all of a drawing, ``use`` says below its name what it is."""

    key: str
    name: str
    use: str
    kind: Kind
    inputs: tuple[InPort, ...] = ()
    outputs: tuple[OutPort, ...] = ()

    @property
    def group(self) -> str:
        """The family of a stage, or what other boxes have in common: they share a colour."""
        return self.use.partition(".")[0] if self.kind in ("source", "stage") else "LCM"


def boxes_of(graph: Graph) -> list[Box]:
    """Return inputs, stages in the file's order, and outputs."""
    stems = dict.fromkeys(given.channel.stage for given in graph.inputs.values())
    inputs = [_input(stem, [i for i in graph.inputs.values() if i.channel.stage == stem]) for stem in stems]
    return [*inputs, *map(_stage, graph.nodes), *map(_output, graph.outputs.values())]


def as_fired(graph: Graph, boxes: list[Box]) -> list[Box]:
    """Return boxes with writers before plain readers: inputs, sources, the other stages as they fire, outputs."""
    by_key = {box.key: box for box in boxes}
    stages = [by_key[node.name] for node in (*graph.sources, *graph.order)]
    inputs, outputs = ([box for box in boxes if box.kind == kind] for kind in ("input", "output"))
    return [*inputs, *stages, *outputs]


def _input(stem: str, given: list[InputChannel]) -> Box:
    ports = tuple(OutPort(i.channel.port, i.channel, i.log.name if i.log else i.name) for i in given)
    return Box(stem, stem, "log" if all(i.log for i in given) else "input", "input", outputs=ports)


def _stage(node: Node) -> Box:
    return Box(
        node.name,
        node.name,
        node.use,
        "source" if node.is_source else "stage",
        tuple(InPort(i.port.name, i.channel, not i.port.is_plain, i.port.reading) for i in node.inputs),
        tuple(OutPort(port, c, c.name if c.name != c.ref else "") for port, c in node.outputs.items()),
    )


def _output(sent: OutputChannel) -> Box:
    use = "motor output" if sent.motor else "output"
    return Box(f"output {sent.channel.ref}", sent.name, use, "output", (InPort(sent.channel.port, sent.channel),))
