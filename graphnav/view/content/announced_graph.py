"""Make the boxes of an announced graph, without loading code except installed stages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from graphnav.catalog import Catalog
from graphnav.errors import CatalogError, UserError
from graphnav.graph import Channel
from graphnav.messages import About, Message
from graphnav.render.boxes import Box, InPort, OutPort
from graphnav.spec import parse_yaml
from graphnav.stage import Port, Source, ports_of

_MAX_BOXES = 200
_MAX_PORTS = 64
_MAX_NAME = 128


@dataclass(frozen=True)
class AnnouncedGraph:
    """The drawing data of a graph.

    ``names``: by the reference of a channel (``stage.port``) the LCM channels of its messages.
    """

    about: str
    boxes: tuple[Box, ...]
    names: Mapping[str, tuple[str, ...]]


def announced_graph(about: About, catalog: Catalog) -> AnnouncedGraph:
    """Return the graph announced by a run; unknown parts are left out.

    Raises
    ------
    UserError
        The announcement is not a graph, or too large to be drawn.
    """
    words = parse_yaml(about.graph_yaml.encode(), "graphnav.about")[0].plain()
    stages = _mapping(words, "stages")
    if not stages or len(stages) > _MAX_BOXES:
        raise UserError.of(f"the graph of the run has {len(stages)} stages, not 1 to {_MAX_BOXES}")
    inputs, outputs = _mapping(words, "inputs"), _mapping(words, "outputs")
    if len(inputs) + len(outputs) > _MAX_BOXES:
        raise UserError.of(f"the graph of the run has more than {_MAX_BOXES} inputs and outputs")
    reader = _Reader(catalog, _mapping(words, "channels"), inputs, outputs, about.channels)
    boxes = _wired([*reader.inputs(), *(reader.stage(name, stages[name]) for name in stages), *reader.outputs()])
    refs = [port.channel.ref for box in boxes for port in box.outputs]
    about_text = words.get("about") if isinstance(words, dict) else None
    return AnnouncedGraph(
        about_text if isinstance(about_text, str) else "", boxes, {ref: reader.names(ref) for ref in refs}
    )


class _Reader:
    """Reads the sections of an announced graph."""

    def __init__(
        self,
        catalog: Catalog,
        renamed: Mapping[str, Any],
        inputs: Mapping[str, Any],
        outputs: Mapping[str, Any],
        channels: tuple[str, ...],
    ) -> None:
        self._catalog, self._renamed, self._inputs, self._outputs = catalog, renamed, inputs, outputs
        self._channels = channels

    def names(self, ref: str) -> tuple[str, ...]:
        """Return the LCM channels of the messages of a channel."""
        named = [self._renamed.get(ref, ref)]
        named += [_mapping(section, ref).get("channel") for section in (self._inputs, self._outputs)]
        return tuple(dict.fromkeys(name for name in named if isinstance(name, str))) or (ref,)

    def stage(self, name: str, words: Any) -> Box:
        """Return the box of a stage; the ports of a stage that is not installed are derived from the wires."""
        use = words.get("use") if isinstance(words, dict) else None
        wires = {port: ref for port, ref in _mapping(words, "in").items() if isinstance(ref, str)}
        try:
            stage_class = self._catalog.stage(str(use))
        except CatalogError:
            inputs = tuple(InPort(port, _channel(ref)) for port, ref in wires.items())
            ports_of_stage = [ref for ref in self._channels if ref.rpartition(".")[0] == name]
            outputs = tuple(self._output(ref, Message) for ref in ports_of_stage[:_MAX_PORTS])
            return Box(name, name, str(use)[:_MAX_NAME], "stage" if wires else "source", inputs[:_MAX_PORTS], outputs)
        ports = ports_of(stage_class)
        return Box(
            name,
            name,
            str(use),
            "source" if issubclass(stage_class, Source) else "stage",
            tuple(_in_port(port, wires.get(port.name)) for port in ports.inputs),
            tuple(self._output(f"{name}.{port.name}", port.message) for port in ports.outputs),
        )

    def inputs(self) -> Iterator[Box]:
        """Yield one box per group of inputs."""
        refs: dict[str, list[str]] = {}
        for ref in self._inputs:
            if stem := ref.rpartition(".")[0]:
                refs.setdefault(stem, []).append(ref)
        for stem, of_stem in refs.items():
            ports = tuple(self._input(ref) for ref in of_stem)
            is_log = all("log" in _mapping(self._inputs, ref) for ref in of_stem)
            yield Box(stem, stem, "log" if is_log else "input", "input", outputs=ports)

    def outputs(self) -> Iterator[Box]:
        """Yield one box per output."""
        for ref in self._outputs:
            words = _mapping(self._outputs, ref)
            use = "motor output" if words.get("motor") is True else "output"
            channel = _channel(ref)
            name = str(words.get("channel", ref))[:_MAX_NAME]
            yield Box(f"output {ref}", name, use, "output", (InPort(channel.port, channel),))

    def _input(self, ref: str) -> OutPort:
        words = _mapping(self._inputs, ref)
        written = str(words["log"]).rpartition("/")[2] if "log" in words else str(words.get("channel", ref))
        return OutPort(ref.rpartition(".")[2], _channel(ref), written[:_MAX_NAME])

    def _output(self, ref: str, message: type[Message]) -> OutPort:
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


def _mapping(words: Any, key: str) -> dict[str, Any]:
    """Return a section, empty if missing, without entries with too long names."""
    found = words.get(key) if isinstance(words, dict) else None
    return {name: item for name, item in found.items() if 0 < len(name) <= _MAX_NAME} if isinstance(found, dict) else {}
