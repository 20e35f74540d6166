"""The boxes of a drawing: stages, inputs and outputs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from graphnav.core.errors import shown_name
from graphnav.core.graph import Channel, Graph, InputChannel, Node, OutputChannel

Kind = Literal["source", "stage", "input", "output"]


@dataclass(frozen=True)
class InPort:
    """An input port in a drawing."""

    name: str
    channel: Channel | None
    is_sampled: bool = False
    reading: str = ""
    """How a port that is not plain is read: "latest" or "since"."""


@dataclass(frozen=True)
class OutPort:
    """An output port in a drawing."""

    name: str
    channel: Channel
    alias: str = ""
    """The LCM channel or log of the port, if its name differs."""


@dataclass(frozen=True)
class Box:
    """One box: ``key`` is unique within the drawing, ``use`` is the subtitle below its name."""

    key: str
    name: str
    use: str
    kind: Kind
    inputs: tuple[InPort, ...] = ()
    outputs: tuple[OutPort, ...] = ()

    @property
    def group(self) -> str:
        """The family of a stage, or the kind of another box: boxes of a group share a colour."""
        return self.use.partition(".")[0] if self.kind in ("source", "stage") else "LCM"


def boxes_of(graph: Graph) -> list[Box]:
    """Return inputs, stages in file order, and outputs."""
    stems = dict.fromkeys(given.channel.stage for given in graph.inputs.values())
    inputs = [_input(stem, [i for i in graph.inputs.values() if i.channel.stage == stem]) for stem in stems]
    return [*inputs, *map(_stage, graph.nodes), *map(_output, graph.outputs.values())]


def as_fired(graph: Graph, boxes: list[Box]) -> list[Box]:
    """Return boxes with writers before plain readers: inputs, sources, other stages in firing order, outputs."""
    by_key = {box.key: box for box in boxes}
    stages = [by_key[node.name] for node in (*graph.sources, *graph.order)]
    inputs, outputs = ([box for box in boxes if box.kind == kind] for kind in ("input", "output"))
    return [*inputs, *stages, *outputs]


def _input(stem: str, given: list[InputChannel]) -> Box:
    ports = tuple(OutPort(i.channel.port, i.channel, shown_name(i.log.name if i.log else i.name)) for i in given)
    return Box(stem, stem, "log" if all(i.log for i in given) else "input", "input", outputs=ports)


def _stage(node: Node) -> Box:
    """Return the box of a stage; one that is not known and that no message fires is taken for a source."""
    is_fired = any(i.port.is_plain for i in node.inputs)
    return Box(
        node.name,
        node.name,
        node.use,
        "source" if node.is_source or (node.is_left_out and not is_fired) else "stage",
        tuple(InPort(i.port.name, i.channel, not i.port.is_plain, i.port.reading) for i in node.inputs),
        tuple(OutPort(port, c, shown_name(c.name) if c.name != c.ref else "") for port, c in node.outputs.items()),
    )


def _output(sent: OutputChannel) -> Box:
    use = "motor output" if sent.motor else "output"
    return Box(
        f"output {sent.channel.ref}", shown_name(sent.name), use, "output", (InPort(sent.channel.port, sent.channel),)
    )


@dataclass(frozen=True)
class Wire:
    """A channel and one of its readers, the key of a box."""

    channel: Channel
    reader: str
    port: str
    latest: bool


def wires_of(boxes: Iterable[Box]) -> list[Wire]:
    """Return every wire, in the order of the readers."""
    return [
        Wire(port.channel, box.key, port.name, port.is_sampled)
        for box in boxes
        for port in box.inputs
        if port.channel is not None
    ]
