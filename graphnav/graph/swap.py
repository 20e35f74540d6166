"""Apply ``--set``: swap stages, rewire what the swap leaves open, prune what nobody reads any more."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from graphnav.catalog import Catalog
from graphnav.errors import CatalogError, Problem, UserError
from graphnav.graph.assignment import Assignment, parse_sets
from graphnav.graph.inputs import input_messages
from graphnav.graph.paths import has_path
from graphnav.graph.prune import prune
from graphnav.messages import Message
from graphnav.spec import Entry, Spec, StageSpec, Value
from graphnav.spec.write import write_value
from graphnav.stage import Port, Stage, params_of, ports_of


def apply_sets(spec: Spec, sets: Sequence[str], catalog: Catalog, problems: list[Problem], notices: list[str]) -> Spec:
    """Return ``spec`` with what ``--set`` options say; what is wrong and what changed is added to the lists."""
    assignments = parse_sets(sets, spec, problems)
    swaps = [a for a in assignments if a.kind == "swap"]
    if swaps:
        _Swap(spec, assignments, catalog, problems, notices).apply(swaps)
    for a in assignments:
        try:
            if a.kind == "run":
                spec.run[a.key] = a.entry
            elif a.kind != "swap" and a.stage not in spec.stages:
                notices.append(f"{a.stage}: pruned, so that '{a.place}' changes nothing")
            elif a.kind == "param":
                spec.stages[a.stage].params[a.key] = a.entry
            elif a.kind == "wire":
                spec.stages[a.stage].wires[a.key] = a.entry
                spec.stages[a.stage].wire_notes[a.key] = str(a.place)
        except UserError as error:
            problems.extend(error.problems)
    return spec


class _Swap:
    """Swaps stages of one graph.

    Wires are kept where name and type of the port are the same. An open plain input is wired to the only channel of
    its type and name, else to the only one of its type; channels that depend on the reader do not count.
    """

    def __init__(
        self,
        spec: Spec,
        assignments: Sequence[Assignment],
        catalog: Catalog,
        problems: list[Problem],
        notices: list[str],
    ) -> None:
        self._spec, self._problems, self._notices = spec, problems, notices
        self._catalog = catalog
        self._given = {(a.stage, a.key): a for a in assignments if a.kind == "wire"}
        self._set_params = {(a.stage, a.key) for a in assignments if a.kind == "param"}
        self._before = self._classes()
        self._write_out_references()
        self._read_before = {ref.partition(".")[0] for _, _, ref in self._wires()}

    def apply(self, swaps: Sequence[Assignment]) -> None:
        """Swap, rewire, prune."""
        swapped = [a.stage for a in swaps if self._replace(a)]
        for given in self._given.values():
            self._spec.stages[given.stage].wires[given.key] = given.entry
        after = self._classes()
        channels = input_messages(self._spec, self._catalog)
        channels |= {f"{stage}.{p.name}": p.message for stage, cls in after.items() for p in ports_of(cls).outputs}
        self._close_broken(swapped, after, channels)
        for stage in swapped:
            if stage in after:
                self._wire_new(self._spec.stages[stage], after[stage], channels)
        prune(self._spec, self._read_before, set(swapped), after, self._notices)

    def _replace(self, swap: Assignment) -> bool:
        stage = self._spec.stages[swap.stage]
        if stage.use == swap.text:
            self._notices.append(f"{stage.name}: it is {swap.text} already")
            return False
        old_use, old = stage.use, self._before.get(stage.name)
        stage.use, stage.use_place, stage.use_note = swap.text, swap.place, str(swap.place)
        try:
            new = self._catalog.stage(swap.text)
        except CatalogError:
            return False  # said by the check of the graph
        kept, dropped = _split_params(stage.params, old, new)
        stage.params = kept
        defaults = self._defaults(stage.name, new, kept)
        notice = f"{stage.name}: {old_use} swapped for {swap.text}"
        notice += f"; defaults: {', '.join(defaults)}" if defaults else ""
        notice += f"; kept: {', '.join(kept)}" if kept else ""
        notice += f"; not carried over: {', '.join(dropped)}" if dropped else ""
        self._notices.append(notice)
        self._keep_wires(stage, old, new)
        return True

    def _defaults(self, stage: str, cls: type[Stage], kept: Mapping[str, Entry]) -> list[str]:
        return [
            f"{name}={write_value(param.default)}"
            for name, param in params_of(cls).items()
            if not param.required and name not in kept and (stage, name) not in self._set_params
        ]

    def _keep_wires(self, stage: StageSpec, old: type[Stage] | None, new: type[Stage]) -> None:
        types = {port.name: port.message for port in ports_of(old).inputs} if old else {}
        new_types = {port.name: port.message for port in ports_of(new).inputs}
        for name, entry in list(stage.wires.items()):
            if name in new_types and types.get(name, new_types[name]) is new_types[name]:
                continue
            del stage.wires[name]
            if name not in new_types:
                self._notices.append(f"{stage.name}.{name}: gone with its wire to {entry.value.data}")

    def _close_broken(
        self, swapped: Sequence[str], after: Mapping[str, type[Stage]], channels: Mapping[str, type[Message]]
    ) -> None:
        """Rewire the readers of outputs that a swap took away."""
        for reader, port, ref in list(self._wires()):
            writer = ref.partition(".")[0]
            if writer not in swapped or reader not in after or (reader, port.name) in self._given:
                continue
            if channels.get(ref) is port.message:
                continue
            del self._spec.stages[reader].wires[port.name]
            same = [r for r, message in channels.items() if message is port.message and r.startswith(f"{writer}.")]
            if len(same) == 1:
                self._wire(self._spec.stages[reader], port, same[0], f"in place of {ref}")
            elif not port.is_plain:
                self._notices.append(f"{reader}.{port.name}: not connected any more, {ref} is gone")
            else:
                self._wire_to_only(self._spec.stages[reader], port, channels, ref)

    def _wire_new(self, stage: StageSpec, cls: type[Stage], channels: Mapping[str, type[Message]]) -> None:
        for port in ports_of(cls).inputs:
            if port.is_plain and port.name not in stage.wires and (stage.name, port.name) not in self._given:
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
        else:
            what = f"input '{port.name}' of stage '{stage.name}' ({stage.use}) needs {kind}"
            what += f" in place of {gone}" if gone else ""
            if candidates:
                what += f", and {len(candidates)} channels have it: {', '.join(candidates)}"
                hint = "choose with " + " or ".join(f"--set {stage.name}.in.{port.name}={ref}" for ref in candidates)
            else:
                what += ", and no channel has it"
                hint = f"add a stage that writes {kind}, or swap '{stage.name}' too"
            cause = self._spec.stages[gone.partition(".")[0]] if gone else stage
            self._problems.append(Problem(cause.use_place, what, hint))
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
            readers = {reader for reader, port, ref in self._wires() if port.is_plain and ref.split(".")[0] in found}
            grew = not readers <= found
            found |= readers
        return found

    def _wires(self) -> Iterator[tuple[str, Port, str]]:
        """Yield (reader, input port, reference) of every wire of a known stage."""
        for name, cls in self._classes().items():
            ports = {port.name: port for port in ports_of(cls).inputs}
            for port_name, entry in self._spec.stages[name].wires.items():
                if port_name in ports:
                    yield name, ports[port_name], str(entry.value.data)

    def _classes(self) -> dict[str, type[Stage]]:
        classes = {}
        for stage in self._spec.stages.values():
            try:
                classes[stage.name] = self._catalog.stage(stage.use)
            except CatalogError:
                continue  # said by the check of the graph
        return classes

    def _write_out_references(self) -> None:
        """Turn references to a stage's one output from ``stage`` into ``stage.port``."""
        for stage in self._spec.stages.values():
            for name, entry in stage.wires.items():
                cls = self._before.get(str(entry.value.data))
                outputs = ports_of(cls).outputs if cls else ()
                if len(outputs) == 1:
                    ref = f"{entry.value.data}.{outputs[0].name}"
                    stage.wires[name] = Entry(entry.place, Value(ref, entry.value.place))


def _split_params(
    params: Mapping[str, Entry], old: type[Stage] | None, new: type[Stage]
) -> tuple[dict[str, Entry], list[str]]:
    """Return the parameters that a swap keeps, paths of the same name, and the names of the others."""
    before = params_of(old) if old else {}
    after = params_of(new)
    kept = {
        name: entry
        for name, entry in params.items()
        if name in before and name in after and has_path(before[name].type) and has_path(after[name].type)
    }
    return kept, [name for name in params if name not in kept]
