"""The boxes of a graph as a run announces it: those of ``graphnav draw``; loads no code but installed stages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TypeVar

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, UserError
from graphnav.core.graph import Channel
from graphnav.core.graph.wiring.stage_class import stage_class
from graphnav.core.messages import About, Message
from graphnav.core.render.boxes import Box, InPort, Kind, OutPort
from graphnav.core.render.geometry import Geometry, Sizes, geometry_of
from graphnav.core.spec import Entry, InputSpec, OutputSpec, Spec, StageSpec, outline_of
from graphnav.core.stage import Port, Source, ports_of

_MAX_BOXES = 200
_MAX_PORTS = 64
_MAX_NAME = 128
T = TypeVar("T")


@dataclass(frozen=True)
class AnnouncedGraph:
    """The boxes of a graph.

    ``names``: by the reference of a channel (``stage.port``) the LCM channels of its messages.
    """

    about: str
    boxes: tuple[Box, ...]
    names: Mapping[str, tuple[str, ...]]

    @staticmethod
    def read(about: About, catalog: Catalog) -> AnnouncedGraph:
        """Return the graph that a run announces; unknown parts are left out.

        Raises
        ------
        UserError
            The announcement is not a graph, or too large to be drawn.
        """
        spec = outline_of(about.graph_yaml.encode(), "graphnav.about")
        reader = _Reader(spec, catalog, about.channels)
        if not 1 <= len(reader.stages) <= _MAX_BOXES:
            raise UserError.of(f"the graph of the run has {len(reader.stages)} stages, not 1 to {_MAX_BOXES}")
        if len(reader.inputs) + len(reader.outputs) > _MAX_BOXES:
            raise UserError.of(f"the graph of the run has more than {_MAX_BOXES} inputs and outputs")
        boxes = _wired(
            [*reader.input_boxes(), *map(reader.stage_box, reader.stages.values()), *reader.output_boxes()],
        )
        refs = [port.channel.ref for box in boxes for port in box.outputs]
        return AnnouncedGraph(spec.about, boxes, {ref: reader.names(ref) for ref in refs})

    def geometry(self, sizes: Sizes) -> Geometry:
        """Return where boxes and wires are drawn."""
        return geometry_of(self.boxes, sizes)


class _Reader:
    """Reads the sections of an announced graph, without entries with too long names."""

    def __init__(self, spec: Spec, catalog: Catalog, channels: tuple[str, ...]) -> None:
        self.stages: Mapping[str, StageSpec] = _short(spec.stages)
        self.inputs: Mapping[str, InputSpec] = _short(spec.inputs)
        self.outputs: Mapping[str, OutputSpec] = _short(spec.outputs)
        self._renamed = _short(spec.channels)
        self._catalog, self._channels = catalog, channels

    def names(self, ref: str) -> tuple[str, ...]:
        """Return the LCM channels of the messages of a channel."""
        sections = (self.inputs.get(ref), self.outputs.get(ref))
        named = [_text(self._renamed.get(ref)) or ref, *(_text(one.ros2 or one.channel) for one in sections if one)]
        return tuple(dict.fromkeys(name for name in named if name))

    def stage_box(self, stage: StageSpec) -> Box:
        """Return the box of a stage; the ports of a stage that is not known are derived from the wires."""
        wires = {port: _text(wire) for port, wire in _short(stage.wires).items()}
        try:
            cls = stage_class(stage, self._catalog, [])
        except CatalogError:
            cls = None
        if cls is None:
            inputs = tuple(InPort(port, _channel(ref)) for port, ref in wires.items())
            ports_of_stage = [ref for ref in self._channels if ref.rpartition(".")[0] == stage.name]
            outputs = tuple(self._out_port(ref, Message) for ref in ports_of_stage[:_MAX_PORTS])
            kind: Kind = "stage" if wires else "source"
            return Box(stage.name, stage.name, stage.use[:_MAX_NAME], kind, inputs[:_MAX_PORTS], outputs)
        ports = ports_of(cls)
        return Box(
            stage.name,
            stage.name,
            stage.use,
            "source" if issubclass(cls, Source) else "stage",
            tuple(_in_port(port, wires.get(port.name)) for port in ports.inputs),
            tuple(self._out_port(f"{stage.name}.{port.name}", port.message) for port in ports.outputs),
        )

    def input_boxes(self) -> Iterator[Box]:
        """Yield one box per group of inputs."""
        refs: dict[str, list[str]] = {}
        for ref in self.inputs:
            if stem := ref.rpartition(".")[0]:
                refs.setdefault(stem, []).append(ref)
        for stem, of_stem in refs.items():
            ports = tuple(OutPort(ref.rpartition(".")[2], _channel(ref), self._origin(ref)) for ref in of_stem)
            is_log = all(self.inputs[ref].log for ref in of_stem)
            yield Box(stem, stem, "log" if is_log else "input", "input", outputs=ports)

    def output_boxes(self) -> Iterator[Box]:
        """Yield one box per output."""
        for ref, sent in self.outputs.items():
            channel, use = _channel(ref), "motor output" if sent.motor else "output"
            name = (_text(sent.ros2 or sent.channel) or ref)[:_MAX_NAME]
            yield Box(f"output {ref}", name, use, "output", (InPort(channel.port, channel),))

    def _origin(self, ref: str) -> str:
        """Return the log, the topic or the LCM channel of an input."""
        given = self.inputs[ref]
        return (_text(given.log).rpartition("/")[2] or _text(given.ros2 or given.channel) or ref)[:_MAX_NAME]

    def _out_port(self, ref: str, message: type[Message]) -> OutPort:
        name = self.names(ref)[0]
        return OutPort(ref.rpartition(".")[2], _channel(ref, message), name[:_MAX_NAME] if name != ref else "")


def _wired(boxes: list[Box]) -> tuple[Box, ...]:
    """Return the boxes, one a key, without wires from missing writers; one becomes a source if there is no other."""
    boxes = [*{box.key: box for box in boxes}.values()]
    written = {port.channel.ref for box in boxes for port in box.outputs}
    kept: list[Box] = []
    for box in boxes:
        inputs = [p if p.channel and p.channel.ref in written else replace(p, channel=None) for p in box.inputs]
        kept.append(replace(box, inputs=tuple(inputs)))
    if not any(box.kind in ("source", "input") for box in kept):
        kept[0] = replace(kept[0], kind="source")
    return tuple(kept)


def _in_port(port: Port, ref: str | None) -> InPort:
    return InPort(port.name, _channel(ref) if ref else None, not port.is_plain, port.reading)


def _channel(ref: str, message: type[Message] = Message) -> Channel:
    return Channel(ref, ref, message)


def _short(section: Mapping[str, T]) -> dict[str, T]:
    return {name: entry for name, entry in section.items() if 0 < len(name) <= _MAX_NAME}


def _text(entry: Entry | None) -> str:
    """Return a string of the graph, empty where it is not given or something else."""
    return entry.value.data if entry is not None and isinstance(entry.value.data, str) else ""
