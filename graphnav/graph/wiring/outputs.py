"""Outputs: channels that leave a live graph for other programs."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.catalog import Catalog
from graphnav.errors import CatalogError, Problem, did_you_mean
from graphnav.graph.node import Channel, OutputChannel
from graphnav.graph.wiring.stop_message import why_no_stop
from graphnav.graph.wiring.wire_type import type_written
from graphnav.messages import Twist
from graphnav.spec import OutputSpec, Spec
from graphnav.stage import Stage


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
        wire = type_written(kind, channel.message, catalog)
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
    if given.channel is None:
        return None
    name = str(given.channel.value.data)
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
    )
