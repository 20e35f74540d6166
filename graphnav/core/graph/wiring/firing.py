"""Firing order: writers before readers, loops that nothing samples, and joins that can never be complete."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from graphnav.core.errors import Problem
from graphnav.core.graph.node import InputChannel, Node

Origins = frozenset[tuple[str, str]]
"""Origins of stamps: the kind of each ("source", "device", "input" or "timer") and its name."""


def firing_order(writers: Mapping[str, Sequence[str]]) -> tuple[list[str], list[list[str]]]:
    """Return stages in firing order and the loops that forbid one.

    ``writers``: for each stage, in the file's order, the stages that its plain inputs read. Ties keep the file's order.
    A loop names its stages in the direction of the data, beginning with the one that comes first in the file.
    """
    waiting = {stage: {w for w in read if w in writers} for stage, read in writers.items()}
    order: list[str] = []
    while ready := next((stage for stage, left in waiting.items() if not left), None):
        order.append(ready)
        del waiting[ready]
        for left in waiting.values():
            left.discard(ready)
    return order, _loops(waiting)


def _loops(waiting: Mapping[str, set[str]]) -> list[list[str]]:
    """Return one loop for each group of stages that wait for each other."""
    loops: list[list[str]] = []
    covered: set[str] = set()
    for stage in waiting:
        if stage in covered:
            continue
        loop = _shortest_loop(stage, waiting)
        if loop:
            loops.append(loop)
            covered |= _reached(stage, waiting)
    return loops


def _shortest_loop(start: str, waiting: Mapping[str, set[str]]) -> list[str]:
    """Return the shortest way from ``start`` back to it along the data, empty if there is none."""
    reader_of: dict[str, str] = {}
    frontier = [start]
    while frontier:
        following = []
        for stage in frontier:
            for writer in [w for w in waiting if w in waiting[stage]]:
                if writer == start:
                    loop = [start, stage]
                    while loop[-1] != start:
                        loop.append(reader_of[loop[-1]])
                    return loop
                if writer not in reader_of:
                    reader_of[writer] = stage
                    following.append(writer)
        frontier = following
    return []


def _reached(start: str, waiting: Mapping[str, set[str]]) -> set[str]:
    """Return every stage on a loop with ``start``."""
    back, forth = _closure(start, waiting), _closure(start, _readers(waiting))
    return back & forth | {start}


def _closure(start: str, edges: Mapping[str, set[str]]) -> set[str]:
    found: set[str] = set()
    stack = [start]
    while stack:
        for other in edges[stack.pop()] - found:
            found.add(other)
            stack.append(other)
    return found


def _readers(writers: Mapping[str, set[str]]) -> dict[str, set[str]]:
    return {stage: {other for other in writers if stage in writers[other]} for stage in writers}


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
        if "source" in kinds and kinds & {"input", "device"}:
            other = "an input" if "input" in kinds else "a device"
            what = f"{who} a simulated source with {other}, whose stamps are never equal: {told}"
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
        return frozenset({("device" if node.is_live_source else "source", node.name)})
    return frozenset({("timer", node.name)}) if node.every_ms is not None else _all(ports)


def _all(ports: Mapping[str, Origins]) -> Origins:
    return frozenset[tuple[str, str]]().union(*ports.values())


def _told(origins: Origins) -> str:
    return " and ".join(f"the {kind} '{name}'" for kind, name in sorted(origins)) or "nowhere"
