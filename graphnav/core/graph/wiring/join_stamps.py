"""Where the stamps that meet in a join come from: stages whose plain inputs can never be complete."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graphnav.core.errors import Problem
from graphnav.core.graph.node import InputChannel, Node

Origins = frozenset[tuple[str, str]]
"""Origins of stamps: the kind of each ("source", "input" or "timer") and its name."""


def check_stamps(
    nodes: Sequence[Node], inputs: Mapping[str, InputChannel], problems: list[Problem], notices: list[str]
) -> None:
    """Add each stage where a simulated source meets an input, and tell of those where independent senders meet.

    ``nodes``: sources first, then in firing order.
    """
    origins = {ref: frozenset({("input", found.sender)}) for ref, found in inputs.items()}
    for node in nodes:
        ports = _ports(node, origins)
        for channel in node.outputs.values():
            origins[channel.ref] = _written(node, ports)
        found = _all(ports)
        if any(part == found for part in ports.values()):
            continue  # there is one, or it was told where they met
        who = f"stage '{node.name}' ({node.use}) joins"
        told = "; ".join(f"'{port}' comes from {_told(part)}" for port, part in ports.items())
        kinds = {kind for kind, _ in found}
        if {"source", "input"} <= kinds:
            what = f"{who} a simulated source with an input, whose stamps are never equal: {told}"
            hint = "take all of it from inputs, or use a stage that reads one as Latest[...] or Since[...]"
            problems.append(Problem(node.place, what, hint))
        elif len({origin for origin in found if origin[0] != "source"}) + ("source" in kinds) > 1:
            notices.append(
                f"{who} independent senders, whose stamps are never equal, so that it never fires: {told}; "
                "read all but one as Latest or Since"
            )


def _ports(node: Node, origins: Mapping[str, Origins]) -> dict[str, Origins]:
    """Return who stamps what its plain inputs read; a loop, told elsewhere, comes from nowhere."""
    return {
        i.port.name: origins.get(i.channel.ref, frozenset())
        for i in node.inputs
        if i.channel is not None and i.port.is_plain
    }


def _written(node: Node, ports: Mapping[str, Origins]) -> Origins:
    if node.is_source:
        return frozenset({("source", node.name)})
    return frozenset({("timer", node.name)}) if node.every_ms is not None else _all(ports)


def _all(ports: Mapping[str, Origins]) -> Origins:
    return frozenset[tuple[str, str]]().union(*ports.values())


def _told(origins: Origins) -> str:
    return " and ".join(f"the {kind} '{name}'" for kind, name in sorted(origins)) or "nowhere"
