"""Check a spec against the catalog and wire it into a graph."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Problem, did_you_mean
from graphnav.core.graph.graph import Graph
from graphnav.core.graph.node import SET, Channel, Input, LeftOut, Node
from graphnav.core.graph.wiring.channels import channels_of, check_outside_names
from graphnav.core.graph.wiring.firing import check_stamps, firing_order
from graphnav.core.graph.wiring.inputs import inputs_of
from graphnav.core.graph.wiring.outputs import outputs_of, unnoticed_faults
from graphnav.core.graph.wiring.processes import parts_of
from graphnav.core.graph.wiring.settings import run_options, settings_of
from graphnav.core.graph.wiring.stage_class import stage_class
from graphnav.core.graph.wiring.wires import Wires
from graphnav.core.messages import Message
from graphnav.core.ros2 import Ros2Network
from graphnav.core.spec import Spec, StageSpec
from graphnav.core.stage import Port, Source, Stage, ports_of

_NOT_USED = {
    "queues": "'queues' is not used in lockstep: there every complete set of inputs fires",
    "outputs": "'outputs' is not used in lockstep: there nothing leaves the run",
}


def classes_of(
    spec: Spec, catalog: Catalog, problems: list[Problem], *, may_lack: bool = False
) -> dict[str, type[Stage]]:
    """Return the class of every stage that is known; what is wrong is added to ``problems``.

    ``may_lack``: stages that the catalog does not have are no error, because plugins were left out.
    """
    classes = {}
    for stage in spec.stages.values():
        with suppress(CatalogError):
            catalog.stage(stage.use)  # its family may define the messages of a stage that stands before it
    for stage in spec.stages.values():
        if not stage.use:
            continue
        try:
            cls = stage_class(stage, catalog, problems)
        except CatalogError as error:
            if catalog.has(stage.use) or not may_lack:
                problems.append(error.problem(stage.use_place))
            continue
        if cls is not None:
            classes[stage.name] = cls
    return classes


def check(
    spec: Spec,
    catalog: Catalog,
    path: Path,
    problems: list[Problem],
    notices: list[str],
    left_out: tuple[Problem, ...] = (),
) -> Graph:
    """Return the graph of a spec, which can be used only if nothing was added to ``problems``.

    ``left_out``: plugins that are not trusted; stages that are not known are taken for theirs.
    """
    classes = classes_of(spec, catalog, problems, may_lack=bool(left_out))
    consumed, inputs = inputs_of(spec, catalog, path.parent, problems)
    channels = channels_of(spec, classes, consumed, problems)
    unknown = _unknown_channels(spec, classes) if left_out else {}
    wires = Wires(spec, classes, channels | unknown, catalog, problems)
    nodes = [_node(spec, cls, name, path.parent, channels, wires, problems) for name, cls in classes.items()]
    drawn = _with_left_out(spec, nodes, channels | unknown) if left_out else nodes
    is_known = bool(spec.stages) and len(classes) == len(spec.stages)
    if is_known and not spec.inputs and not any(node.is_source for node in nodes):
        what = "the graph has no source: nothing would ever fire"
        problems.append(Problem(spec.stages_place, what, "add a world, a video or another Source"))
    order = _order(spec, drawn, problems)
    _check_queues(spec, nodes, problems)
    written = {ref: channel for ref, channel in channels.items() if ref not in spec.inputs}
    sent = outputs_of(spec, classes, written, catalog, problems)
    check_outside_names(spec, channels, inputs, sent, problems)
    notices += unnoticed_faults(drawn, sent)
    is_live = bool(inputs) or any(node.is_live_source for node in nodes)
    if is_live:
        sources = [node for node in nodes if node.is_source]
        check_stamps(sources + [node for node in order if node in nodes], inputs, problems, notices)
    notices += [text for key, text in _NOT_USED.items() if getattr(spec, key) and not is_live]
    return Graph(
        path=path,
        about=spec.about,
        nodes=tuple(drawn),
        order=tuple(order),
        channels=channels,
        run=run_options(spec.run, problems),
        notices=tuple(notices),
        inputs=inputs,
        outputs=sent,
        queues={ref: queue.keep for ref, queue in spec.queues.items()},
        ros2=Ros2Network() if spec.ros2 is None else Ros2Network(spec.ros2.domain, spec.ros2.interface),
        deploy=parts_of(spec, classes, problems),
        left_out=left_out,
    )


def _node(
    spec: Spec,
    cls: type[Stage],
    name: str,
    folder: Path,
    channels: Mapping[str, Channel],
    wires: Wires,
    problems: list[Problem],
) -> Node:
    stage = spec.stages[name]
    settings = settings_of(stage, cls, folder, problems, spec.folders)
    outputs = {port.name: channels[f"{name}.{port.name}"] for port in ports_of(cls).outputs}
    reads, times = wires.inputs_of(stage), _times_of(stage, cls, problems)
    return Node(name, stage.use, cls, settings, reads, outputs, stage.place, **times, use_note=stage.use_note)


def _unknown_channels(spec: Spec, classes: Mapping[str, type[Stage]]) -> dict[str, Channel]:
    """Return the channels of stages that are not known, by what reads them; their type is not known either."""
    words = (str(entry.value.data) for stage in spec.stages.values() for entry in stage.wires.values())
    refs = [ref for ref in words if (name := ref.partition(".")[0]) in spec.stages and name not in classes]
    named = {ref.partition(".")[0]: ref for ref in refs if "." in ref}  # a stage alone means its one output
    full = {ref: ref if "." in ref else named.get(ref, f"{ref}.output") for ref in refs}
    return {ref: Channel(full[ref], full[ref], Message) for ref in refs}


def _with_left_out(spec: Spec, nodes: list[Node], channels: Mapping[str, Channel]) -> list[Node]:
    """Return all stages in the file's order; those that are not known have the ports that wires name.

    Which of these are sampled is not known either: those that would close a loop are taken for it.
    """
    known = {node.name: node for node in nodes}
    writers = {name: known[name].writers if name in known else [] for name in spec.stages}
    for name in [name for name in spec.stages if name not in known]:
        stage, reads = spec.stages[name], []
        for port, entry in stage.wires.items():
            channel = channels.get(str(entry.value.data))
            longer = writers | {name: [*writers[name], channel.stage]} if channel else writers
            is_sampled = bool(firing_order(longer)[1])
            writers = writers if is_sampled else longer
            reads.append(Input(Port(port, Message, latest=is_sampled), channel))
        writes = {channel.port: channel for channel in channels.values() if channel.stage == name}
        known[name] = Node(name, stage.use, LeftOut, {}, tuple(reads), writes, stage.place)
    return [known[name] for name in spec.stages]


def _order(spec: Spec, nodes: list[Node], problems: list[Problem]) -> list[Node]:
    by_name = {node.name: node for node in nodes}
    order, loops = firing_order({node.name: node.writers for node in nodes})
    for loop in loops:
        reader = by_name[loop[0]]
        port = next(i.port.name for i, channel in _plain(reader) if channel.stage == loop[-2])
        place = spec.stages[reader.name].wires[port].value.place
        what = f"a loop without a sampled input never fires: {' -> '.join(loop)}"
        how = (
            f"by its parameters {', '.join(reader.stage_class.ports_from)}"
            if reader.stage_class.ports_from
            else "Latest[...]"
        )
        hint = f"make one of its inputs sampled, for instance '{port}' of {reader.use}: {how}"
        problems.append(Problem(place, what, hint))
    return [by_name[name] for name in order if not by_name[name].is_source]


def _plain(node: Node) -> list[tuple[Input, Channel]]:
    return [(i, i.channel) for i in node.inputs if i.channel is not None and i.port.is_plain]


def _times_of(stage: StageSpec, cls: type[Stage], problems: list[Problem]) -> dict[str, Any]:
    if "every_ms" in stage.times and issubclass(cls, Source):
        what = f"stage '{stage.name}' ({stage.use}) is a source: 'every_ms' is for stages that messages fire"
        problems.append(Problem(stage.times["every_ms"].place, what, "write with: {rate_hz: ...}"))
    notes = {key: SET for key, entry in stage.times.items() if entry.is_override}
    return {key: entry.value.data for key, entry in stage.times.items()} | {"time_notes": notes}


def _check_queues(spec: Spec, nodes: list[Node], problems: list[Problem]) -> None:
    known = {f"{node.name}.{port.name}": port for node in nodes for port in ports_of(node.stage_class).inputs}
    unclear = set(spec.stages) - {node.name for node in nodes}
    for ref, queue in spec.queues.items():
        if ref in known and not known[ref].is_plain:
            what = f"'{ref}' is read as {known[ref].reading.title()}: only an input that fires its stage has a queue"
            problems.append(Problem(queue.place, what, "remove it"))
        elif ref not in known and ref.partition(".")[0] not in unclear:
            problems.append(Problem(queue.place, f"no stage has an input '{ref}'", did_you_mean(ref, known)))
