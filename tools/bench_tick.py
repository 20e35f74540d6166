"""Benchmark the overhead of a tick against a bare python-lcm loop that moves and logs the same bytes.

The two take turns tick by tick in one process, so that both meet the same caches and the same noise of the machine.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from pathlib import Path

import lcm

from graphnav.bus import Bus
from graphnav.catalog import Catalog
from graphnav.graph import load_graph
from graphnav.record import LogWriter
from graphnav.runner import Runner
from graphnav.runner.owned_stages import Sink
from graphnav.tap import Tap

GRAPH = "corridor_ccw"
SEED = 3
TAP_URL = "udpm://239.255.76.67:7699?ttl=0"
WARM_UP = 20


class Kept:
    """A sink that keeps the messages of a tick."""

    def __init__(self) -> None:
        self.events: list[tuple[str, int, bytes]] = []

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Keep one message."""
        self.events.append((channel, utime, data))


class BareLoop:
    """Publishes, receives and logs with python-lcm alone."""

    def __init__(self, channels: list[str], log: Path) -> None:
        self._lcm = lcm.LCM("memq://")
        self._log = lcm.EventLog(str(log), "w", overwrite=True)
        self._utime = 0
        for channel in channels:
            self._lcm.subscribe(channel, self._receive)

    def run(self, events: list[tuple[str, int, bytes]]) -> float:
        """Move one tick's messages; return the seconds that it took."""
        begin = time.perf_counter()
        for channel, utime, data in events:
            self._utime = utime
            self._lcm.publish(channel, data)
            self._lcm.handle()
        return time.perf_counter() - begin

    def _receive(self, channel: str, data: bytes) -> None:
        self._log.write_event(self._utime, channel, data)


def measure(ticks: int = 250, graph_name: str = GRAPH, *, tapped: bool = False) -> dict[str, float]:
    """Return medians over the ticks, ms: what the runner spends beyond ``step``, and the bare loop."""
    with tempfile.TemporaryDirectory() as scratch:
        graph = load_graph(graph_name, Catalog())
        kept, writer = Kept(), LogWriter(Path(scratch) / "ours.lcmlog")
        tap = Tap("thin", "bench", TAP_URL) if tapped else None
        sinks: list[Sink] = [writer, kept]
        if tap:
            sinks.append(tap)
        runner = Runner(graph, graph.make_stages(), Bus("memq://"), sinks)
        runner.reset(SEED)
        bare = BareLoop([channel.name for channel in graph.channels.values()], Path(scratch) / "bare.lcmlog")
        units = runner.units.values()
        beyond, loop, kilobytes = [], [], []
        for _ in range(ticks):
            kept.events.clear()
            inside = sum(unit.durations.total_s for unit in units)
            begin = time.perf_counter()
            runner.tick()
            wall_s = time.perf_counter() - begin
            beyond.append(wall_s - (sum(unit.durations.total_s for unit in units) - inside))
            loop.append(bare.run(kept.events))
            kilobytes.append(sum(len(data) for _, _, data in kept.events) / 1e3)
        writer.close()
        if tap:
            tap.close()
        runner.close()
    beyond, loop = beyond[WARM_UP:], loop[WARM_UP:]
    return {
        "kB a tick": statistics.median(kilobytes),
        "beyond the steps, ms": statistics.median(beyond) * 1e3,
        "bare loop, ms": statistics.median(loop) * 1e3,
        "ratio": statistics.median(beyond) / statistics.median(loop),
    }


if __name__ == "__main__":
    for name, with_tap in (("log on", False), ("log and tap on", True)):
        print(name, {figure: round(value, 3) for figure, value in measure(tapped=with_tap).items()})
