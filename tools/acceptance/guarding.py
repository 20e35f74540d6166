"""Acceptance of the guard in lockstep: it passes every command of the shipped graphs that can see unchanged."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from acceptance.drives import drive, say
from graphnav import Recording, Twist
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_graphs

RESTRICTED = {"white_wall"}
"""Graphs in which the guard has to restrict commands."""


def guard_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive every lockstep graph with a guard over the seeds; print how many commands it changed of how many."""
    passed = True
    for name in shipped_graphs():
        graph = load_graph(name, Catalog())
        guards = [node.name for node in graph.nodes if node.stage_class.is_guard]
        if graph.is_live or not guards or name in RESTRICTED:
            continue
        with ThreadPoolExecutor(jobs) as pool:
            drives = list(pool.map(lambda seed, name=name: _compared(name, seed), seeds))
        changed, commands = (sum(drive[k] for drive in drives) for k in (0, 1))
        passed &= changed == 0 and commands > 0
        mark = "ok  " if changed == 0 and commands else "MISS"
        say(f"{mark} {name}: {changed} of {commands} commands changed in {len(seeds)} drives")
    return passed


def _compared(graph: str, seed: int) -> tuple[int, int]:
    """Return how many commands the guard changed, added or held back in a drive, and how many there were."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        drive(graph, seed, ("run.record=small",), folder)
        with Recording(folder / "run.lcmlog") as log:
            before, after = (_commands(log, channel) for channel in ("control.twist", "guard.twist"))
    return len(before.items() ^ after.items()), len(before)


def _commands(log: Recording, channel: str) -> dict[int, tuple[float, float]]:
    """Return the first command of every stamp: the stop at the end of a recording takes back the last one."""
    found: dict[int, tuple[float, float]] = {}
    for utime, _, message in log.messages(channel):
        if isinstance(message, Twist):
            found.setdefault(utime, (message.v_mps, message.omega_radps))
    return found
