"""Rewire what a swapped, added or removed stage leaves open."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

from graphnav.core.catalog import Catalog
from graphnav.core.errors import CatalogError, Hint, Place, Problem, Suggestion
from graphnav.core.graph.node import SET
from graphnav.core.graph.wiring.inputs import input_messages
from graphnav.core.graph.wiring.stage_class import stage_class
from graphnav.core.graph.wiring.wires import add_writer
from graphnav.core.messages import Message
from graphnav.core.spec import Entry, Spec, StageSpec, Value
from graphnav.core.stage import Port, Stage, ports_of


class Rewiring:
    """Rewires stages of one graph.

    An open plain input is wired to the only channel of its type and name, else to the only one of its type; channels
    that depend on the reader and those of scores do not count. What cannot be wired is added to ``problems``, what was
    done to ``notices``. A sampled input of true data is wired alike, and stays open where that is not clear.
    ``given``: (stage, input port) of wires that are given with the change and stay as they are.
    """

    def __init__(
        self,
        spec: Spec,
        catalog: Catalog,
        given: Collection[tuple[str, str]],
        problems: list[Problem],
        notices: list[str],
    ) -> None:
        self._spec, self._catalog, self._given = spec, catalog, given
        self._problems, self._notices = problems, notices
        self._added: Collection[str] = ()

    def rewire(self, swapped: Collection[str], added: Collection[str] = ()) -> None:
        """Rewire the readers of outputs that swaps took away, then the open inputs of swapped and added stages."""
        self._added = added
        channels = input_messages(self._spec, self._catalog)
        channels |= {
            f"{stage}.{port.name}": port.message
            for stage, cls in self.classes().items()
            for port in ports_of(cls).outputs
            if cls.role != "score"
        }
        self._close_broken(swapped, channels)
        for stage in (*swapped, *added):
            if stage in self.classes():
                self._wire_new(self._spec.stages[stage], channels)

    def remove(self, removed: Mapping[str, Place]) -> None:
        """Disconnect the readers of stages and inputs that were removed, each at its place."""
        for reader, port, ref in list(self.wires()):
            place, stage = self._removal(ref, removed), self._spec.stages[reader]
            if place is None:
                continue
            wire = stage.wires.pop(port.name).value.place
            who = f"'{port.name}' of stage '{reader}' ({stage.use})"
            if wire.file == place.file:
                what = f"{who} reads {ref}, which is removed in line {place.line}"
                self._problems.append(Problem(wire, what, "wire it to another stage, or keep the one that it reads"))
            elif port.is_plain:
                hint = f"remove '{reader}' too, or write {reader}: {{in: {{{port.name}: stage.port}}}}"
                self._problems.append(Problem(place, f"{who} reads {ref}, which is removed here", hint))
            else:
                self._notices.append(f"{reader}.{port.name}: not connected any more, {ref} is gone")
                continue
            stage.unwired.add(port.name)

    def _removal(self, ref: str, removed: Mapping[str, Place]) -> Place | None:
        """Return where the stage or the input that a reference means was removed, None if it was not."""
        stem, dot, _ = ref.partition(".")
        if dot or any(name.partition(".")[0] == stem for name in self._spec.inputs):
            return removed.get(ref) or removed.get(stem)
        return removed.get(stem) or next((p for name, p in removed.items() if name.partition(".")[0] == stem), None)

    def wires(self) -> Iterator[tuple[str, Port, str]]:
        """Yield (reader, input port, reference) of every wire of a known stage."""
        for name, cls in self.classes().items():
            ports = {port.name: port for port in ports_of(cls).inputs}
            for port_name, entry in self._spec.stages[name].wires.items():
                if port_name in ports and entry.value.data is not None:
                    yield name, ports[port_name], str(entry.value.data)

    def classes(self) -> dict[str, type[Stage]]:
        """Return the class of every stage that is known."""
        classes = {}
        for stage in self._spec.stages.values():
            try:
                cls = stage_class(stage, self._catalog, [])
            except CatalogError:
                continue  # reported by the check of the graph
            if cls is not None:
                classes[stage.name] = cls
        return classes

    def _close_broken(self, swapped: Collection[str], channels: Mapping[str, type[Message]]) -> None:
        for reader, port, ref in list(self.wires()):
            writer = ref.partition(".")[0]
            if writer not in swapped or (reader, port.name) in self._given:
                continue
            if channels.get(ref) is port.message:
                continue
            del self._spec.stages[reader].wires[port.name]
            same = [r for r, message in channels.items() if message is port.message and r.startswith(f"{writer}.")]
            if len(same) == 1:
                self._wire(self._spec.stages[reader], port, same[0], f"in place of {ref}")
            elif port.may_be_open:
                self._notices.append(f"{reader}.{port.name}: not connected any more, {ref} is gone")
            else:
                self._wire_to_only(self._spec.stages[reader], port, channels, ref)

    def _wire_new(self, stage: StageSpec, channels: Mapping[str, type[Message]]) -> None:
        for port in ports_of(self.classes()[stage.name]).inputs:
            if port.name in stage.wires or (stage.name, port.name) in self._given:
                continue
            if not port.may_be_open or port.message.is_truth:
                self._wire_to_only(stage, port, channels)

    def _wire_to_only(
        self, stage: StageSpec, port: Port, channels: Mapping[str, type[Message]], gone: str = ""
    ) -> None:
        downstream = self._downstream(stage.name)
        candidates = [
            ref
            for ref, message in channels.items()
            if message is port.message and ref.partition(".")[0] not in downstream
        ]
        named = [ref for ref in candidates if ref.partition(".")[2] == port.name]
        kind = port.message.__name__
        if len(named) == 1:
            self._wire(stage, port, named[0], f"the only {kind} called '{port.name}'")
        elif len(candidates) == 1:
            self._wire(stage, port, candidates[0], f"the only {kind}")
        elif not port.may_be_open:
            self._cannot_wire(stage, port, candidates, gone)

    def _cannot_wire(self, stage: StageSpec, port: Port, candidates: list[str], gone: str) -> None:
        kind, is_added = port.message.__name__, stage.name in self._added
        cause = self._spec.stages[gone.partition(".")[0]] if gone else stage
        what = f"input '{port.name}' of stage '{stage.name}' ({stage.use}) needs {kind}"
        what += f" in place of {gone}" if gone else ""
        if candidates:
            what += f", and {len(candidates)} channels have it: {', '.join(candidates)}"
            hint: Hint = _choice(stage.name, port.name, candidates, is_set=bool(cause.use_note))
        else:
            what += ", and no channel has it"
            hint = add_writer(port.message, self._catalog, SET if cause.use_note else "")
            hint += "" if is_added else f", or swap '{stage.name}' too"
        self._problems.append(Problem(cause.use_place, what, hint, "ambiguous" if candidates else "wrong"))
        stage.unwired.add(port.name)

    def _wire(self, stage: StageSpec, port: Port, ref: str, reason: str) -> None:
        place = stage.use_place if stage.use_note else stage.place
        stage.wires[port.name] = Entry(place, Value(ref, place))
        stage.wire_notes[port.name] = f"rewired: {reason}"
        self._notices.append(f"{stage.name}.{port.name}: wired to {ref}, {reason}")

    def _downstream(self, start: str) -> set[str]:
        """Return ``start`` and every stage that depends on it through plain inputs."""
        found, grew = {start}, True
        while grew:
            readers = {reader for reader, port, ref in self.wires() if port.is_plain and ref.split(".")[0] in found}
            grew = not readers <= found
            found |= readers
        return found


def _choice(stage: str, port: str, candidates: list[str], *, is_set: bool) -> Suggestion:
    """Return the hint to choose a channel, on the command line or in the file; its names are overrides."""
    overrides = tuple(f"{stage}.in.{port}={ref}" for ref in candidates)
    options = [f"{SET} {words}" for words in overrides]
    words = options if is_set else [f"{stage}: {{in: {{{port}: {ref}}}}}" for ref in candidates]
    return Suggestion(overrides, f"choose with {' or '.join(words)}")
