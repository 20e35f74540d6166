"""Cost: what `view`, with no browser open, and the full-screen `spy` together take of a run's tick rate.

Both listen to the run's tap on the same machine, so that what they take of the processors counts, too. Runs alone, with
them, and with two bare python-lcm programs that hear the same and do nothing take turns; each is several drives of
corridor_ccw at full speed, of the same seeds.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from bench_spy import cpu_s, spy_in_terminal
from scipy import stats
from testbed.drives import GRAPHNAV
from testbed.processes import await_listeners, group_port, group_url

from tests.targets import Targets

GROUP = 96
URL, PORT = group_url(GROUP), group_port(GROUP)
GRAPH = "corridor_ccw"
PAIRS = 20
SEEDS = (1000, 1001, 1002)
MAX_COST_RATIO = 0.05
CONFIDENCE = 0.95
_START_S = 60.0
_SETTLE_S = 3.0
_BARE = """
import sys, lcm
bus = lcm.LCM(sys.argv[1])
bus.subscribe(".*", lambda channel, data: None).set_queue_capacity(0)
while True:
    bus.handle()
"""


_Listeners = Callable[[str], AbstractContextManager[dict[str, int]]]
"""Lets programs listen while it is entered, with a folder to write to; tells the process ids of those to measure."""


@dataclass(frozen=True)
class _Measured:
    """The tick rate of a run, and what each program that watched it took of a core meanwhile."""

    ticks_per_s: float
    core_ratios: dict[str, float]


def test_cost(targets: Targets) -> None:
    """Each round's tick rates, then the mean cost and its upper bound (95 %, one-sided, Student's t)."""
    costs, bare_costs = [], []
    turns: list[tuple[str, _Listeners]] = [
        ("alone", lambda _: nullcontext({})),
        ("watched", _watching),
        ("bare", _bare),
    ]
    for pair in range(PAIRS):
        runs = {name: _measure(listeners) for name, listeners in (turns if pair % 2 else reversed(turns))}
        alone, watched, bare = (runs[name] for name, _ in turns)
        costs.append(1 - watched.ticks_per_s / alone.ticks_per_s)
        bare_costs.append(1 - bare.ticks_per_s / alone.ticks_per_s)
        took = ", ".join(f"{name} took {ratio:.1%} of a core" for name, ratio in watched.core_ratios.items())
        rates = f"{alone.ticks_per_s:.1f} ticks/s alone, {watched.ticks_per_s:.1f} watched"
        targets.say(f"{rates}: costs {costs[-1]:+.1%}; {took}; two bare listeners cost {bare_costs[-1]:+.1%}")
    bare_mean, bare_upper = statistics.fmean(bare_costs), upper_bound(bare_costs)
    targets.say(f"two bare python-lcm listeners cost {bare_mean:+.2%}, upper {CONFIDENCE:.0%} bound {bare_upper:+.2%}")
    mean, upper = statistics.fmean(costs), upper_bound(costs)
    bound = f"upper {CONFIDENCE:.0%} bound (one-sided) {upper:+.2%}, to be below {MAX_COST_RATIO:.0%}"
    text = f"view and spy together cost {mean:+.2%} of the tick rate, {bound}; {PAIRS} pairs"
    targets.check(text, good=upper < MAX_COST_RATIO)


def upper_bound(values: Sequence[float]) -> float:
    """Return the upper end of the one-sided 95 % interval of the mean."""
    error = statistics.stdev(values) / math.sqrt(len(values))
    return statistics.fmean(values) + float(stats.t.ppf(CONFIDENCE, len(values) - 1)) * error


def _measure(listeners: _Listeners) -> _Measured:
    """Return the ticks a second over all drives, starting and drawing aside."""
    ticks, wall_s = 0, 0.0
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        pids = stack.enter_context(listeners(str(folder)))
        begin_s, before_s = time.monotonic(), {name: cpu_s(pid) for name, pid in pids.items()}
        for seed in SEEDS:
            command = [str(GRAPHNAV), "run", GRAPH, "--seed", str(seed), "--no-pictures", "-o", str(folder / str(seed))]
            subprocess.run(command, check=True, capture_output=True, env=os.environ | {"LCM_DEFAULT_URL": URL})
            summary = json.loads((folder / str(seed) / "summary.json").read_text(encoding="utf-8"))
            ticks += summary["frames"]
            wall_s += summary["wall_s"]
        for_s = time.monotonic() - begin_s
        return _Measured(ticks / wall_s, {name: (cpu_s(pid) - before_s[name]) / for_s for name, pid in pids.items()})


@contextmanager
def _watching(folder: str) -> Iterator[dict[str, int]]:
    """Let the page's server and a spy in a terminal listen while entered; yield their process ids."""
    view = subprocess.Popen([str(GRAPHNAV), "view", URL, "--port", "0"], stdout=subprocess.DEVNULL)
    with view, spy_in_terminal([URL], folder, 50, 200) as (spy, _):
        try:
            await_listeners(PORT, 2, _START_S)
            time.sleep(_SETTLE_S)  # the start of a program is not a cost of watching
            yield {"view": view.pid, "spy": spy.pid}
        finally:
            view.terminate()


@contextmanager
def _bare(_folder: str) -> Iterator[dict[str, int]]:
    """Let two programs listen that do nothing with what they hear."""
    words = [sys.executable, "-c", _BARE, URL]
    with subprocess.Popen(words) as one, subprocess.Popen(words) as other:
        try:
            await_listeners(PORT, 2, _START_S)
            time.sleep(_SETTLE_S)
            yield {}
        finally:
            one.kill()
            other.kill()
