"""The guard passes every command of the shipped graphs that can see unchanged, over the reporting seeds."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from testbed.drives import drive

from graphnav import Recording, Twist
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, shipped_graphs
from tests.targets import Targets

RESTRICTED = {"white_wall"}
"""Graphs in which the guard has to restrict commands."""


@pytest.mark.parametrize("name", sorted(set(shipped_graphs()) - RESTRICTED))
def test_guard(targets: Targets, seeds: range, jobs: int, tmp_path: Path, name: str) -> None:
    """Of every lockstep graph with a guard: how many commands it changed of how many."""
    graph = load_graph(name, Catalog())
    if graph.is_live or not any(node.stage_class.is_guard for node in graph.nodes):
        pytest.skip("no lockstep graph with a guard")
    with ThreadPoolExecutor(jobs) as pool:
        drives = list(pool.map(lambda seed: _compared(name, seed, tmp_path / f"{seed}"), seeds))
    changed, commands = (sum(drive[k] for drive in drives) for k in (0, 1))
    text = f"{name}: {changed} of {commands} commands changed in {len(seeds)} drives"
    targets.check(text, good=changed == 0 and commands > 0)


def _compared(graph: str, seed: int, folder: Path) -> tuple[int, int]:
    """Return how many commands the guard changed, added or held back in a drive, and how many there were."""
    drive(graph, seed, ("run.record=small",), folder)
    with Recording(folder / "run.lcmlog") as log:
        before, after = (_commands(log, channel) for channel in (_read_by_guard(graph), "guard.twist"))
    return len(before.items() ^ after.items()), len(before)


def _read_by_guard(graph: str) -> str:
    """Return the channel of the commands that the guard lets through."""
    return "policy.twist" if graph.startswith("learned/") else "control.twist"


def _commands(log: Recording, channel: str) -> dict[int, tuple[float, float]]:
    """Return the first command of every stamp: the stop at the end of a recording takes back the last one."""
    found: dict[int, tuple[float, float]] = {}
    for utime, _, message in log.messages(channel):
        if isinstance(message, Twist):
            found.setdefault(utime, (message.v_mps, message.omega_radps))
    return found
