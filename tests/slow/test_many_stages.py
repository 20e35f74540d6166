"""Many channels and many stages: no message is lost between processes, and a message costs what it does among few."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from statistics import median

import bench_growth
import passing_stages
import pytest
from bench_growth import PASSING

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, graph_of
from graphnav.core.run_folder import RunFolder
from graphnav.live.run import run_live
from graphnav.processes.run import run_live_processes
from tests.targets import Targets

N_PAIRS = 4
N_CHANNELS = N_PAIRS * passing_stages.N_CHANNELS
RATE_HZ, UNTIL_S = 100, 10.0
COUNTS = (10, 100, 300)
MAX_RATIO = 1.2
ROUNDS = 5
URL = "udpm://239.255.82.4:7994?ttl=0"


def _graph(folder: Path) -> Graph:
    """Return the graph in which each of the processes sends or takes 75 channels."""
    ports = [f"c{k}" for k in range(passing_stages.N_CHANNELS)]
    lines = [f"run: {{until_s: {UNTIL_S}, record: all}}", "stages:"]
    for k in range(N_PAIRS):
        wires = ", ".join(f"{port}: send{k}.{port}" for port in ports)
        lines.append(f"  send{k}: {{use: passing.send, with: {{rate_hz: {RATE_HZ}}}}}")
        lines.append(f"  take{k}: {{use: passing.take, in: {{{wires}}}}}")
    catalog = Catalog().add_files([PASSING])
    graph = graph_of("\n".join(lines).encode(), folder / "many.yaml", catalog)
    assert len(graph.channels) == N_CHANNELS
    return replace(graph, plugins=(PASSING,)).with_processes()


def test_three_hundred_channels_over_eight_processes(targets: Targets, tmp_path: Path) -> None:
    """Live: firings that a source skipped, messages that were overtaken, and what arrived and is in the log."""
    graph = _graph(tmp_path)
    notices: list[str] = []
    summary = run_live_processes(run_live, graph, {}, tmp_path, url=URL, notice=notices.append)
    live = summary.live or {}
    sent = sum(did.steps for name, did in summary.stages.items() if name.startswith("send"))
    taken = sum(int(scores["sets"]) for scores in summary.scores.values())
    overtaken = sum(edge["overtaken"] for edge in live["edges"])
    with Recording(tmp_path / RunFolder.LOG) as log:
        logged = sum(log.count(channel.name) for channel in graph.channels.values())
    due = round(N_PAIRS * RATE_HZ * UNTIL_S)
    targets.check(
        f"{N_CHANNELS} channels at {RATE_HZ} Hz over {len(graph.deploy)} processes for {UNTIL_S:g} s: {sent} of {due} "
        f"firings of sources, {taken} sets of {passing_stages.N_CHANNELS} messages taken, {overtaken} messages "
        f"overtaken, {logged} in the log, {live['log_dropped']} dropped by it; {len(notices)} notices",
        good=abs(sent - due) <= N_PAIRS
        and taken == sent
        and not overtaken
        and not live["log_dropped"]
        and logged == sent * passing_stages.N_CHANNELS,
    )


@pytest.mark.parametrize("fans_out", [False, True], ids=["chain", "fan-out"])
def test_the_time_of_a_message_does_not_depend_on_the_number_of_stages(
    targets: Targets, tmp_path: Path, fans_out: bool
) -> None:
    """Medians of several rounds, in turns, of processor time in one process."""
    measure = partial(bench_growth.message_us, tmp_path, fans_out=fans_out)
    rounds = [[measure(count) for count in COUNTS] for _ in range(ROUNDS)]
    each_us = [median(column) for column in zip(*rounds, strict=True)]
    times = ", ".join(f"{us:.1f} with {count}" for count, us in zip(COUNTS, each_us, strict=True))
    ratio = max(each_us) / min(each_us)
    what = "a fan-out" if fans_out else "a chain"
    targets.check(f"{what}: {times} stages, µs a message; ratio {ratio:.2f}", good=ratio <= MAX_RATIO)
