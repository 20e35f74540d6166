"""Wires: what each input reads, checked against what the stages write."""

from __future__ import annotations

from collections.abc import Mapping

from graphnav.core.catalog import Catalog
from graphnav.core.errors import Hint, Place, Problem, did_you_mean
from graphnav.core.graph.node import Channel, Input
from graphnav.core.graph.wiring.roles import is_of_score, refusal
from graphnav.core.messages import Message
from graphnav.core.spec import Spec, StageSpec
from graphnav.core.stage import Port, Stage, ports_of

_MAX_WRITERS = 2
"""More stages that write a type are not named in a hint."""


def add_writer(message: type[Message], catalog: Catalog, option: str = "") -> str:
    """Return the hint to add a stage that writes a message type, with those that are installed if they are few.

    ``option``: what precedes an override, such as ``--set``; without it the line of a graph's file is given.
    """
    writers, kind = catalog.writers(message), message.__name__
    if not writers:
        return f"add a stage that writes {kind}"
    if len(writers) > _MAX_WRITERS:
        return f"add a stage that writes {kind} ('graphnav stages {kind}' lists them)"
    name = writers[0].partition(".")[2]
    line = f"{option} {name}+={writers[0]}" if option else f"{name}: {{use: {writers[0]}}}"
    return f"add {' or '.join(writers)}, as {line}"


class Wires:
    """Resolves references of a graph and says what is wrong with them."""

    def __init__(
        self,
        spec: Spec,
        classes: Mapping[str, type[Stage]],
        channels: Mapping[str, Channel],
        catalog: Catalog,
        problems: list[Problem],
    ) -> None:
        self._spec, self._classes, self._channels, self._problems = spec, classes, channels, problems
        self._catalog = catalog

    def inputs_of(self, stage: StageSpec) -> tuple[Input, ...]:
        """Return the inputs of a stage, without those that something is wrong with."""
        ports = {port.name: port for port in ports_of(self._classes[stage.name]).inputs}
        meant = set(stage.unwired)
        for name, entry in stage.wires.items():
            if name not in ports:
                hint = did_you_mean(name, ports)
                meant |= set(hint.names)
                known = f"it has {', '.join(ports)}" if ports else "it has none"
                what = f"{stage.use} has no input '{name}'"
                self._problems.append(Problem(entry.place, what, hint or known, "unknown"))
        inputs = [self._input(stage, port, said=stage.unclear or port.name in meant) for port in ports.values()]
        return tuple(i for i in inputs if i is not None)

    def _input(self, stage: StageSpec, port: Port, *, said: bool) -> Input | None:
        """Return an input; ``said``: something is wrong with it already."""
        entry = stage.wires.get(port.name)
        if entry is None or entry.value.data is None:
            if port.may_be_open:
                return Input(port, None)
            if not said:
                what = f"input '{port.name}' of stage '{stage.name}' ({stage.use}) is not connected"
                candidates = self._of_type(port, stage.name) or ["stage.port"]
                hint = "write " + " or ".join(f"in: {{{port.name}: {ref}}}" for ref in candidates)
                place = stage.place if entry is None else entry.place
                self._problems.append(Problem(place, what, hint + self._no_writer(port)))
            return None
        channel = self._channel(str(entry.value.data), entry.value.place)
        if channel is None:
            return None
        if channel.message is not port.message and channel.message is not Message:
            what = (
                f"'{port.name}' of stage '{stage.name}' ({stage.use}) takes {port.message.__name__}, but "
                f"{self._writer(channel)} is {channel.message.__name__}"
            )
            candidates = self._of_type(port, stage.name) or ["another stage"]
            hint = f"wire it to {' or '.join(candidates)}{self._no_writer(port)}"
            self._problems.append(Problem(entry.value.place, what, hint))
            return None
        if found := refusal(stage, port.name, channel, self._writer(channel), self._classes):
            self._problems.append(Problem(entry.value.place, *found))
            return None
        return Input(port, channel, stage.wire_notes.get(port.name, ""))

    def _writer(self, channel: Channel) -> str:
        """Return what writes a channel, as errors name it."""
        if channel.ref in self._spec.inputs:
            return f"the input '{channel.ref}'"
        return f"'{channel.port}' of stage '{channel.stage}' ({self._spec.stages[channel.stage].use})"

    def _channel(self, ref: str, place: Place) -> Channel | None:
        """Return what a reference means; ``stage`` alone is its one output, the stem of an input its one port."""
        stage, dot, port = ref.partition(".")
        if ref in self._channels:
            return self._channels[ref]
        if not stage:
            self._problems.append(Problem(place, "this names no stage", "write stage.port"))
            return None
        inputs = [other for other in self._spec.inputs if other.partition(".")[0] == stage]
        if inputs and stage not in self._spec.stages:
            return self._input_channel(ref, inputs, place)
        if stage not in self._spec.stages:
            hint: Hint = did_you_mean(ref, self._channels) or did_you_mean(stage, self._spec.stages)
            renamed = next((c.ref for c in self._channels.values() if c.name == ref), "")
            heard = next((i for i, given in self._spec.inputs.items() if given.channel_name == ref), "")
            if renamed or heard:
                hint = f"write '{renamed or heard}': inputs name the stage's port, not the LCM channel"
            what = f"there is no stage{' or input' if self._spec.inputs else ''} '{stage}'"
            self._problems.append(Problem(place, what, hint or "write stage.port"))
        elif stage in self._classes:
            self._no_port(stage, port, dot, place)
            outputs = self._outputs(stage)
            if not dot and len(outputs) == 1:
                return self._channels[outputs[0]]
        return None

    def _input_channel(self, ref: str, inputs: list[str], place: Place) -> Channel | None:
        """Return what a reference to a stem of inputs means; what is wrong with an input itself is told there."""
        stem, dot, _ = ref.partition(".")
        if not dot and len(inputs) == 1:
            return self._channels.get(inputs[0])
        if not dot:
            what = f"there are {len(inputs)} inputs of '{ref}'"
            self._problems.append(Problem(place, what, f"write one of {', '.join(inputs)}"))
        elif ref not in inputs and stem not in inputs:
            hint = did_you_mean(ref, inputs) or f"inputs are {', '.join(inputs)}"
            self._problems.append(Problem(place, f"there is no input '{ref}'", hint))
        return None

    def _no_port(self, stage: str, port: str, dot: str, place: Place) -> None:
        outputs = self._outputs(stage)
        who = f"stage '{stage}' ({self._spec.stages[stage].use})"
        if not outputs:
            self._problems.append(Problem(place, f"{who} has no outputs", "wire this to another stage"))
        elif dot:
            names = [ref.partition(".")[2] for ref in outputs]
            hint = did_you_mean(port, names) or f"it has {', '.join(names)}"
            self._problems.append(Problem(place, f"{who} has no output '{port}'", hint))
        elif len(outputs) > 1:
            what = f"{who} has {len(outputs)} outputs"
            self._problems.append(Problem(place, what, f"write one of {', '.join(outputs)}"))

    def _outputs(self, stage: str) -> list[str]:
        return [ref for ref, channel in self._channels.items() if channel.stage == stage]

    def _no_writer(self, port: Port) -> str:
        """Return what to add to a hint where the graph has no channel of the type, as far as its stages are known."""
        known = len(self._classes) == len(self._spec.stages)
        missing = known and all(channel.message is not port.message for channel in self._channels.values())
        if not missing:
            return ""
        return f"; no stage here writes {port.message.__name__}: {add_writer(port.message, self._catalog)}"

    def _of_type(self, port: Port, reader: str) -> list[str]:
        """Return the channels that an input could read."""
        return [
            c.ref
            for c in self._channels.values()
            if c.message is port.message and c.stage != reader and not is_of_score(c, self._classes)
        ]
