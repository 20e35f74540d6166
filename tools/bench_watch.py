"""Benchmark a run at full speed beside watchers: the full-screen spy and a recorder; then the sizes of its logs.

One process makes run after run, whose taps take turns between a group that both watch and one without a listener, so
that both meet the same noise of the machine. Compared are neighbouring runs: the wall time of their ticks, and the
processor time of the process of the run, tap and log included. The watchers and their terminal are processes of their
own. Wall time is that of two free cores only where the machine has them: on a busy one a watcher takes from the run
what it would take from an idle core.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import subprocess
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from time import process_time
from typing import NamedTuple, get_args

from bench_spy import cpu_s, spy_in_terminal
from taking_turns import Ratio, results_in_turn
from testbed.drives import GRAPHNAV
from testbed.processes import await_listeners, end

import graphnav
from graphnav.core.run_folder import RunFolder
from graphnav.core.spec import RecordOption

GRAPH, SIZED = "corridor_ccw", ("corridor_ccw", "pillars", "navigate")
PORT = 7987
WATCHED, ALONE = f"udpm://239.255.83.5:{PORT}?ttl=0", f"udpm://239.255.83.6:{PORT + 1}?ttl=0"
LIMIT = 0.05
_START_S = 60.0
_SIZED_S = 20.0


class Cost(NamedTuple):
    """Of a tick, s: wall time, processor time of the run's process, and that of spy and recorder together."""

    wall_s: float
    cpu_s: float
    watchers_s: float


def run_once(url: str, until_s: float) -> tuple[int, float, float]:
    """Make a run whose tap is on a group, in the process of the runs; return its ticks, wall and processor time."""
    os.environ["LCM_DEFAULT_URL"] = url
    with tempfile.TemporaryDirectory() as folder:
        begin_s = process_time()
        run = graphnav.run(GRAPH, until_s=until_s, folder=Path(folder) / "run", tap="thin", pictures=False)
        return run.summary.frames, run.summary.wall_s, process_time() - begin_s


def watched_and_alone(rounds: int, until_s: float) -> tuple[list[Cost], list[Cost]]:
    """Return what runs cost that are watched, and what their neighbours cost that are not."""
    with (
        tempfile.TemporaryDirectory() as folder,
        ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as runs,
        spy_in_terminal([WATCHED], folder, 50, 200) as (spy, _),
        subprocess.Popen([GRAPHNAV, "record", WATCHED, "-o", f"{folder}/log"], stdout=subprocess.DEVNULL) as recorder,
    ):
        await_listeners(PORT, 2, _START_S)

        def measure(url: str) -> Cost:
            before_s = cpu_s(spy.pid) + cpu_s(recorder.pid)
            ticks, wall_s, run_s = runs.submit(run_once, url, until_s).result()
            return Cost(wall_s / ticks, run_s / ticks, (cpu_s(spy.pid) + cpu_s(recorder.pid) - before_s) / ticks)

        rivals: dict[str, Callable[[], Cost]] = {url: partial(measure, url) for url in (WATCHED, ALONE)}
        found = results_in_turn(rivals, rounds, warm_up=1)
        end(recorder)
    return found[WATCHED], found[ALONE]


def log_mb_a_minute(graph: str, record: RecordOption) -> float:
    """Return how fast the log of a graph grows, per minute of simulated time."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run"
        run = graphnav.run(graph, until_s=_SIZED_S, folder=path, record=record, pictures=False)
        return (path / RunFolder.LOG).stat().st_size / 1e6 / run.summary.sim_s * 60


def main() -> int:
    """Print what watching costs and how large logs are; return 1 unless the cost is surely below the limit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=30, help="runs of each kind (default: 30)")
    parser.add_argument("--until", type=float, default=20.0, help="simulated seconds of each (default: 20)")
    args = parser.parse_args()
    watched, alone = watched_and_alone(args.rounds, args.until)
    pairs = list(zip(watched, alone, strict=True))
    wall = Ratio.of([one.wall_s / other.wall_s for one, other in pairs])
    cpu = Ratio.of([one.cpu_s / other.cpu_s for one, other in pairs])
    watchers = Ratio.of([one.watchers_s / one.cpu_s for one in watched])
    verdict = "ok  " if wall.high - 1 <= LIMIT else "MISS"
    print(f"{verdict} watch cost: {wall.median - 1:.1%} (at most {wall.high - 1:.1%}), limit {LIMIT:.0%}", flush=True)
    print(f"processor time of the run {cpu}; spy and recorder take {watchers} of that of the run", flush=True)
    for graph in SIZED:
        sizes = (f"{record} {log_mb_a_minute(graph, record):.1f}" for record in get_args(RecordOption))
        print(f"{graph}: MB a minute of its log: {', '.join(sizes)}", flush=True)
    return 0 if wall.high - 1 <= LIMIT else 1


if __name__ == "__main__":
    raise SystemExit(main())
