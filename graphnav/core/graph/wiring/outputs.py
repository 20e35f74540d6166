"""Outputs: channels that leave a live graph for other programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Problem, did_you_mean
from graphnav.core.graph.node import Channel, Node, OutputChannel
from graphnav.core.graph.wiring.stop_message import why_no_stop
from graphnav.core.graph.wiring.wire_type import ros_type_written, type_written
from graphnav.core.messages import Message, Twist
from graphnav.core.spec import OutputSpec, Spec
from graphnav.core.stage import Stage


def outputs_of(
    spec: Spec,
    classes: Mapping[str, type[Stage]],
    channels: Mapping[str, Channel],
    catalog: Catalog,
    problems: list[Problem],
) -> dict[str, OutputChannel]:
    """Return what leaves, by the reference of what is sent; what is wrong is added to ``problems``.

    ``channels``: those that stages write. A motor output must come from a guard with a timer and must have a
    stop; a `Twist` must say whether it is one.
    """
    outputs = {}
    for ref, given in spec.outputs.items():
        stage = ref.partition(".")[0]
        if ref not in channels:
            if stage in classes or stage not in spec.stages:
                hint = did_you_mean(ref, channels) or f"channels are {', '.join(channels)}"
                hint = "name what a stage writes" if ref in spec.inputs else hint
                problems.append(Problem(given.place, f"'outputs' names '{ref}', which no stage writes", hint))
            continue
        if found := _output(ref, given, channels[ref], catalog, problems):
            outputs[ref] = found
        if given.motor and classes[stage].role == "score":
            what = f"the motor output '{ref}' comes from a score, which only measures"
            problems.append(Problem(given.place, what, "send the command of a guard that is not a score"))
        elif given.motor and not classes[stage].is_guard:
            what = f"the motor output '{ref}' does not come from a guard: nothing stops it when its inputs are lost"
            hint = f"put control.guard behind '{stage}' and write outputs: {{guard.twist: ...}}"
            problems.append(Problem(given.place, what, hint))
        elif given.motor and not spec.stages[stage].has_timer:
            what = (
                f"the guard '{stage}' of the motor output '{ref}' has no timer: "
                "it would not notice that nothing comes any more"
            )
            problems.append(Problem(spec.stages[stage].place, what, f"write every_ms: 50 under '{stage}'"))
    return outputs


def _output(
    ref: str, given: OutputSpec, channel: Channel, catalog: Catalog, problems: list[Problem]
) -> OutputChannel | None:
    kind = None if given.type is None else str(given.type.value.data)
    try:
        written = type_written if given.ros2 is None else ros_type_written
        wire = written(kind, channel.message, catalog)
    except CatalogError as error:
        place = given.place if given.type is None else given.type.value.place
        problems.append(Problem(place, f"the output '{ref}': {error.what}", error.hint))
        return None
    stop = None if given.stop is None else given.stop.value.plain()
    if given.motor and not given.unclear and (reason := why_no_stop(wire, stop)):
        place = given.place if given.stop is None else given.stop.value.place
        hint = f"write stop: {{field: value}} with the fields of {wire.name} that make it stand still"
        problems.append(Problem(place, f"the motor output '{ref}' has no stop: {reason}", hint))
    if given.motor is None and not given.unclear and issubclass(channel.message, Twist):
        what = (
            f"the output '{ref}' carries a {channel.message.__name__}, but does not say whether something moves by it"
        )
        problems.append(Problem(given.place, what, "write motor: true, or motor: false if nothing moves by it"))
    named = given.ros2 or given.channel
    if named is None:
        return None
    name = str(named.value.data)
    return OutputChannel(
        channel,
        name,
        wire.lcm_class,
        wire.name,
        wire.adapter,
        bool(given.motor),
        given.max_age_s,
        stop,
        given.place,
        wire.ros_type,
    )


def unnoticed_faults(nodes: Sequence[Node], outputs: Mapping[str, OutputChannel]) -> Iterator[str]:
    """Yield a notice for every fault that the guard of a motor output cannot notice as it is wired, and the wire."""
    by_name = {node.name: node for node in nodes}
    guards = {output.channel.stage: ref for ref, output in outputs.items() if output.motor}
    for name, ref in guards.items():
        guard = by_name.get(name)
        if guard is None or guard.is_left_out or not guard.stage_class.unnoticed:
            continue
        made_from = _made_from(guard, by_name)
        open_ports = {i.port.name: i.port.message for i in guard.inputs if i.channel is None}
        for port, types, fault in guard.stage_class.unnoticed:
            wanted = open_ports.get(port)
            if wanted is not None and made_from & set(types):
                refs = [one.ref for node in nodes for one in node.outputs.values() if one.message is wanted]
                remedy = (
                    f"write in: {{{port}: {refs[0]}}}"
                    if refs
                    else f"wire a stage that writes {wanted.__name__}: 'graphnav stages {wanted.__name__}' lists them"
                )
                yield (
                    f"the guard '{name}' ({guard.use}) of the motor output '{ref}' cannot notice {fault}, since its "
                    f"'{port}' is not wired: {remedy}"
                )


def _made_from(node: Node, by_name: Mapping[str, Node]) -> set[type[Message]]:
    """Return the types of all messages that what a node reads is made from."""
    types, pending, seen = set[type[Message]](), [node], set[str]()
    while pending:
        for read in pending.pop().inputs:
            if read.channel is not None and read.channel.ref not in seen:
                seen.add(read.channel.ref)
                types.add(read.channel.message)
                pending += [by_name[name] for name in (read.channel.stage,) if name in by_name]
    return types
