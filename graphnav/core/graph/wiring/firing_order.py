"""Firing order: writers before readers, and loops that nothing samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence


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
