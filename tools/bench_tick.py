"""Benchmark the overhead of a tick against a hand-written python-lcm loop that runs the same stages to the same log.

Beside it stands a bare loop that only moves and logs the bytes. All take turns tick by tick in one process, so that
they meet the same noise of the machine.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import lcm
from hand_written_loop import HandWrittenLoop
from taking_turns import load_told, take_turns, timed

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph
from graphnav.core.record import LogWriter
from graphnav.core.runner import Lockstep
from graphnav.core.runner.engine import Sink
from graphnav.core.tap import Tap

GRAPH = "corridor_ccw"
SEED = 3
TAP_URL = "udpm://239.255.76.67:7699?ttl=0"
WARM_UP = 20

Recorded = Mapping[str, list[Any]]
"""Results of the first steps of each stage, by the stage's name."""


class Kept:
    """A sink that keeps the messages of a tick."""

    def __init__(self) -> None:
        self.events: list[tuple[str, int, bytes]] = []

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Keep one message."""
        self.events.append((channel, utime, data))


class BareLoop:
    """Publishes, receives and logs given bytes with python-lcm alone."""

    def __init__(self, channels: Sequence[str], log: Path) -> None:
        self._lcm = lcm.LCM("memq://")
        self._log = lcm.EventLog(str(log), "w", overwrite=True)
        self._utime = 0
        for channel in channels:
            self._lcm.subscribe(channel, self._receive)

    def run(self, events: Sequence[tuple[str, int, bytes]]) -> float:
        """Move one tick's messages; return the seconds that it took."""
        begin = time.perf_counter()
        for channel, utime, data in events:
            self._utime = utime
            self._lcm.publish(channel, data)
            self._lcm.handle()
        return time.perf_counter() - begin

    def _receive(self, channel: str, data: bytes) -> None:
        self._log.write_event(self._utime, channel, data)


def beyond_s(tick: Callable[[], object], inside_s: Callable[[], float]) -> Callable[[], float]:
    """Return a rival that ticks a runner or a loop and costs what that takes beyond the stages' steps, s."""
    cost = timed(tick)

    def beyond() -> float:
        before_s = inside_s()
        return cost() - (inside_s() - before_s)

    return beyond


def without_scores(graph: Graph, folder: Path) -> Graph:
    """Return the graph without its score stages, as a file in ``folder`` that extends it."""
    scores = [node.name for node in graph.nodes if node.use.startswith("score.")]
    path = folder / "without_scores.yaml"
    path.write_text(f"extends: {graph.path}\nstages: {{{', '.join(f'{name}: null' for name in scores)}}}\n")
    return load_graph(path, Catalog())


def measure(ticks: int = 250, *, tapped: bool = False, scores: bool = True, stepping: bool = True) -> dict[str, float]:
    """Return medians over the ticks, and their ratios.

    Times in ms, all with a log: ``beyond the steps, ms``, what the runner spends beyond ``step``; ``hand-written, ms``,
    what the hand-written loop spends beyond it; ``bare loop, ms``. ``ratio``: the first / the second; ``bare ratio``:
    the first / the third; ``kB a tick``. If ``tapped``, also ``tapped, ms``, what a second runner with a tap spends,
    and ``tap ratio``: that / the first.

    ``scores``: whether the graph keeps its score stages. ``stepping``: false replaces each step by the return of what
    it returned in the third tick, so that messages and log alone fill the processor's caches.
    """
    with tempfile.TemporaryDirectory() as scratch, ExitStack() as cleanup:
        folder = Path(scratch)
        graph = load_graph(GRAPH, Catalog())
        if not scores:
            graph = without_scores(graph, folder)
        recorded = {} if stepping else _recorded(graph)
        kept = Kept()
        ours, tapping = _timed(graph, recorded, folder / "ours.lcmlog", [kept], cleanup), None
        if tapped:
            tap = Tap("thin", "bench", TAP_URL)
            cleanup.callback(tap.close)
            tapping = _timed(graph, recorded, folder / "tapped.lcmlog", [tap], cleanup)
        loop = HandWrittenLoop(_stages(graph, recorded), SEED, folder / "hand.lcmlog")
        bare = BareLoop([channel.name for channel in graph.channels.values()], folder / "bare.lcmlog")
        kilobytes = []

        def tick() -> float:
            kept.events.clear()
            cost_s = ours()
            kilobytes.append(sum(len(data) for _, _, data in kept.events) / 1e3)
            return cost_s

        rivals = {"ours": tick, "hand": beyond_s(loop.tick, lambda: loop.inside_s)}
        rivals |= {"tapped": tapping} if tapping else {}
        turns = take_turns(rivals | {"bare": lambda: bare.run(kept.events)}, ticks - WARM_UP, WARM_UP)
        loop.close()
        cleanup.close()
        assert _same_events(folder / "ours.lcmlog", folder / "hand.lcmlog")
    metrics = {
        "kB a tick": statistics.median(kilobytes),
        "beyond the steps, ms": 1e3 * turns.median("ours"),
        "hand-written, ms": 1e3 * turns.median("hand"),
        "bare loop, ms": 1e3 * turns.median("bare"),
        "ratio": turns.ratio("ours", "hand").median,
        "bare ratio": turns.ratio("ours", "bare").median,
    }
    if tapping:
        metrics |= {"tapped, ms": 1e3 * turns.median("tapped"), "tap ratio": turns.ratio("tapped", "ours").median}
    return metrics


def _recorded(graph: Graph) -> Recorded:
    """Return what the steps of each stage return in the first three ticks."""
    stages: dict[str, Any] = dict(graph.make_stages())
    recorded: Recorded = {name: [] for name in stages}
    for name, stage in stages.items():
        stage.step = _recording(stage.step, recorded[name])
    lockstep = Lockstep(graph, stages, [])
    lockstep.reset(SEED)
    for _ in range(3):
        lockstep.tick()
    lockstep.engine.close()
    return recorded


def _recording(step: Callable[..., Any], results: list[Any]) -> Callable[..., Any]:
    def record(**inputs: Any) -> Any:
        results.append(step(**inputs))
        return results[-1]

    return record


def _stages(graph: Graph, recorded: Recorded) -> dict[str, Any]:
    """Return new stages, whose steps return what was ``recorded`` of them, the last result from then on."""
    stages: dict[str, Any] = dict(graph.make_stages())
    for name, results in recorded.items():
        stages[name].step = _returning([*reversed(results)])
    return stages


def _returning(results: list[Any]) -> Callable[..., Any]:
    def step(**_: Any) -> Any:
        return results.pop() if len(results) > 1 else results[0]

    return step


def _timed(
    graph: Graph, recorded: Recorded, log: Path, sinks: Sequence[Sink], cleanup: ExitStack
) -> Callable[[], float]:
    """Return a rival that is a run, reset and ready to tick, which also writes a log."""
    writer = LogWriter(log)
    cleanup.callback(writer.close)
    lockstep = Lockstep(graph, _stages(graph, recorded), [writer, *sinks])
    cleanup.callback(lockstep.engine.close)
    lockstep.reset(SEED)
    units = tuple(lockstep.engine.units.values())
    return beyond_s(lockstep.tick, lambda: sum(unit.durations.total_s for unit in units))


def _same_events(one: Path, other: Path) -> bool:
    """Whether two logs have the same events, in the order of their channels within a tick."""
    logs = [
        sorted((event.timestamp, event.channel, event.data) for event in lcm.EventLog(str(path), "r"))
        for path in (one, other)
    ]
    return logs[0] == logs[1]


def main() -> None:
    """Print the times with and without score stages, with the tap, and without the steps."""
    for what, metrics in (
        ("with scores", measure()),
        ("without scores", measure(scores=False)),
        ("with tap", measure(tapped=True)),
        ("without the steps", measure(stepping=False)),
    ):
        listed = ", ".join(f"{name} {value:.3f}" for name, value in metrics.items())
        sys.stdout.write(f"{what}: {listed}\n")


if __name__ == "__main__":
    with load_told():
        main()
