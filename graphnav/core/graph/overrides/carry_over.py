"""Carry over what a swapped stage keeps: wires of the same name and type, paths of the same name."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from graphnav.core.graph.paths import has_path
from graphnav.core.spec import Entry, Value
from graphnav.core.spec.write import write_value
from graphnav.core.stage import Source, Stage, params_of, ports_of


def kept_params(params: Mapping[str, Entry], old: type[Stage] | None, new: type[Stage]) -> dict[str, Entry]:
    """Return the parameters that a swap keeps: paths of the same name, and what simulators with one ``step`` share.

    A tuned value is not carried over to a rival. What two simulators inherit with their ``step`` says what world it is,
    and which robot drives through it: the other one simulates the same.
    """
    before = params_of(old) if old else {}
    after = params_of(new)
    return {
        name: entry
        for name, entry in params.items()
        if name in before
        and name in after
        and ((has_path(before[name].type) and has_path(after[name].type)) or _inherit_both(name, old, new))
    }


def _inherit_both(name: str, old: type[Stage] | None, new: type[Stage]) -> bool:
    """Whether both are sources with the ``step`` of one class, which declares or inherits this parameter."""
    if old is None or not (issubclass(old, Source) and issubclass(new, Source)):
        return False
    owner, other = (next(cls for cls in one.__mro__ if "step" in vars(cls)) for one in (old, new))
    return owner is other and name in params_of(owner)


def kept_wires(wires: Mapping[str, Entry], old: type[Stage] | None, new: type[Stage]) -> dict[str, Entry]:
    """Return the wires that a swap keeps: those of inputs with the same name and type."""
    types = {port.name: port.message for port in ports_of(old).inputs} if old else {}
    new_types = {port.name: port.message for port in ports_of(new).inputs}
    return {
        name: entry
        for name, entry in wires.items()
        if name in new_types and types.get(name, new_types[name]) is new_types[name]
    }


def lost_wires(stage: str, wires: Mapping[str, Entry], new: type[Stage]) -> list[str]:
    """Return a notice for every wire of an input that the new stage does not have."""
    names = [port.name for port in ports_of(new).inputs]
    return [
        f"{stage}.{name}: gone with its wire to {entry.value.data}"
        for name, entry in wires.items()
        if name not in names
    ]


def params_notice(
    what: str,
    cls: type[Stage],
    kept: Collection[str] = (),
    lost: Collection[str] = (),
    given: Collection[str] = (),
) -> str:
    """Return a notice of a new stage: ``what`` happened, and which parameters are defaults, kept or not carried over.

    ``given``: parameters that are given with the new stage.
    """
    kept = [name for name in kept if name not in given]
    defaults = [
        f"{name}={write_value(param.default)}"
        for name, param in params_of(cls).items()
        if not param.required and name not in kept and name not in given
    ]
    parts = (("defaults", defaults), ("kept", kept), ("not carried over", lost))
    return what + "".join(f"; {title}: {', '.join(names)}" for title, names in parts if names)


def written_out(wire: Entry, classes: Mapping[str, type[Stage]]) -> Entry:
    """Return a wire to a stage's one output, ``stage``, as ``stage.port``; any other as it is."""
    cls = classes.get(str(wire.value.data))
    outputs = ports_of(cls).outputs if cls else ()
    if len(outputs) != 1:
        return wire
    return Entry(wire.place, Value(f"{wire.value.data}.{outputs[0].name}", wire.value.place))
