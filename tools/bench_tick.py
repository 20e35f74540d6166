"""Benchmark the overhead of a tick against the same work in a hand-written python-lcm loop.

Beside it stands a bare loop that moves and logs the bytes and looks at none. All take turns tick by tick in one
process, so that they meet the same caches and the same noise of the machine.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import lcm
from hand_written_types import HAND_WRITTEN

from graphnav.bus import Bus
from graphnav.catalog import Catalog
from graphnav.codec import decode
from graphnav.graph import Graph, load_graph
from graphnav.record import LogWriter
from graphnav.runner import Runner
from graphnav.runner.owned_stages import Sink
from graphnav.tap import Tap

GRAPH = "corridor_ccw"
SEED = 3
TAP_URL = "udpm://239.255.76.67:7699?ttl=0"
WARM_UP = 20


class Published(NamedTuple):
    """A message of a tick, as bytes and as the fields that a stage returned."""

    channel: str
    utime: int
    data: bytes
    seq: int
    message: Any


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

    def run(self, published: Sequence[Published]) -> float:
        """Move one tick's messages; return the seconds that it took."""
        begin = time.perf_counter()
        for one in published:
            self._utime = one.utime
            self._lcm.publish(one.channel, one.data)
            self._lcm.handle()
        return time.perf_counter() - begin

    def _receive(self, channel: str, data: bytes) -> None:
        self._log.write_event(self._utime, channel, data)


class HandWrittenLoop:
    """Encodes and checks the messages, logs them, publishes those that a stage reads, receives and decodes them."""

    def __init__(self, graph: Graph, log: Path) -> None:
        self._lcm = lcm.LCM("memq://")
        self._log = lcm.EventLog(str(log), "w", overwrite=True)
        self.inbox: dict[str, tuple[Any, ...]] = {}
        self._put, self._take = {}, {}
        self._read = {i.channel.name for node in graph.nodes for i in node.inputs if i.channel is not None}
        for channel in graph.channels.values():
            if channel.message.lcm_class in HAND_WRITTEN:
                self._put[channel.name], self._take[channel.name] = HAND_WRITTEN[channel.message.lcm_class]
                if channel.name in self._read:
                    self._lcm.subscribe(channel.name, self._receive)

    def run(self, published: Sequence[Published]) -> float:
        """Handle one tick's messages; return the seconds that it took."""
        begin = time.perf_counter()
        for channel, utime, _, seq, message in published:
            data = self._put[channel](utime, seq, message)
            self._log.write_event(utime, channel, data)
            if channel in self._read:
                self._lcm.publish(channel, data)
                self._lcm.handle()
        return time.perf_counter() - begin

    def check(self, published: Sequence[Published]) -> None:
        """Assert that its bytes are those of the runner."""
        for channel, utime, data, seq, message in published:
            assert self._put[channel](utime, seq, message) == data, channel

    def _receive(self, channel: str, data: bytes) -> None:
        self.inbox[channel] = self._take[channel](data)


@dataclass
class TimedRunner:
    """A runner with its log, and what its ticks cost beyond the stages' steps, seconds."""

    runner: Runner
    beyond_s: list[float]

    def tick(self) -> None:
        """Run one tick."""
        units = self.runner.units.values()
        inside_s = sum(unit.durations.total_s for unit in units)
        begin = time.perf_counter()
        self.runner.tick()
        wall_s = time.perf_counter() - begin
        self.beyond_s.append(wall_s - (sum(unit.durations.total_s for unit in units) - inside_s))

    @property
    def beyond_ms(self) -> float:
        """The median."""
        return statistics.median(self.beyond_s[WARM_UP:]) * 1e3


def without_scores(graph: Graph, folder: Path) -> Graph:
    """Return the graph without its score stages, as a file in ``folder`` that extends it."""
    scores = [node.name for node in graph.nodes if node.use.startswith("score.")]
    path = folder / "without_scores.yaml"
    path.write_text(f"extends: {graph.path}\nstages: {{{', '.join(f'{name}: null' for name in scores)}}}\n")
    return load_graph(path, Catalog())


def measure(
    ticks: int = 250, graph_name: str = GRAPH, *, tapped: bool = False, scores: bool = True
) -> dict[str, float]:
    """Return medians over the ticks, and what they give.

    ``kB a tick``; ``beyond the steps, ms``: what the runner spends beyond ``step``, with a log; ``hand-written, ms`` and
    ``bare loop, ms``: the two loops, with a log; ``ratio``: beyond the steps / hand-written; ``bare ratio``: beyond the
    steps / bare loop. If ``tapped``, also ``tapped, ms``: what a second runner spends, with a tap, and ``tap ratio``:
    that / beyond the steps. ``scores``: whether the graph keeps its score stages.
    """
    with tempfile.TemporaryDirectory() as scratch, ExitStack() as cleanup:
        graph = load_graph(graph_name, Catalog())
        if not scores:
            graph = without_scores(graph, Path(scratch))
        kept = Kept()
        runners = [_timed(graph, Path(scratch) / "ours.lcmlog", [kept], cleanup)]
        if tapped:
            tap = Tap("thin", "bench", TAP_URL)
            cleanup.callback(tap.close)
            runners.append(_timed(graph, Path(scratch) / "tapped.lcmlog", [tap], cleanup))
        bare = BareLoop([channel.name for channel in graph.channels.values()], Path(scratch) / "bare.lcmlog")
        hand = HandWrittenLoop(graph, Path(scratch) / "hand.lcmlog")
        classes = {channel.name: channel.message for channel in graph.channels.values()}
        bare_s, hand_s, kilobytes = [], [], []
        for tick in range(ticks):
            kept.events.clear()
            for runner in runners:
                runner.tick()
            published = []
            for channel, utime, data in kept.events:
                if classes[channel].lcm_class in HAND_WRITTEN:
                    _, seq, message = decode(classes[channel], data)
                    published.append(Published(channel, utime, data, seq, message))
            if tick < WARM_UP:
                hand.check(published)
            bare_s.append(bare.run(published))
            hand_s.append(hand.run(published))
            kilobytes.append(sum(len(data) for _, _, data in kept.events) / 1e3)
    ours_ms = runners[0].beyond_ms
    hand_ms, bare_ms = statistics.median(hand_s[WARM_UP:]) * 1e3, statistics.median(bare_s[WARM_UP:]) * 1e3
    figures = {
        "kB a tick": statistics.median(kilobytes),
        "beyond the steps, ms": ours_ms,
        "hand-written, ms": hand_ms,
        "bare loop, ms": bare_ms,
        "ratio": ours_ms / hand_ms,
        "bare ratio": ours_ms / bare_ms,
    }
    if tapped:
        figures |= {"tapped, ms": runners[1].beyond_ms, "tap ratio": runners[1].beyond_ms / ours_ms}
    return figures


def _timed(graph: Graph, log: Path, sinks: Sequence[Sink], cleanup: ExitStack) -> TimedRunner:
    """Return a runner that also writes a log, reset and ready to tick."""
    writer = LogWriter(log)
    cleanup.callback(writer.close)
    runner = Runner(graph, graph.make_stages(), Bus("memq://"), [writer, *sinks])
    cleanup.callback(runner.close)
    runner.reset(SEED)
    return TimedRunner(runner, [])


def main() -> None:
    """Print the figures with and without score stages, and those of the tap."""
    for what, figures in (
        ("with scores", measure()),
        ("without scores", measure(scores=False)),
        ("with tap", measure(tapped=True)),
    ):
        listed = ", ".join(f"{name} {value:.3f}" for name, value in figures.items())
        sys.stdout.write(f"{what}: {listed}\n")


if __name__ == "__main__":
    main()
