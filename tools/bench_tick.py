"""What a tick costs beyond its steps, against a bare python-lcm loop that moves and logs the same bytes."""

from __future__ import annotations

import gc
import itertools
import statistics
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import lcm

from graphnav import Recording
from graphnav.bus import Bus
from graphnav.catalog import Catalog
from graphnav.graph import load_graph
from graphnav.record import LogWriter
from graphnav.record.event import Event
from graphnav.runner import Runner
from graphnav.runner.lockstep import Sink
from graphnav.runner.recorded import LOG, run_recorded
from graphnav.tap import Tap

GRAPH = "corridor_ccw"
SEED = 3
TAP_URL = "udpm://239.255.76.67:7699?ttl=0"


def ticks_of(log: Path) -> list[list[Event]]:
    """Return the events of a log, a list a tick."""
    with Recording(log) as recording:
        events = list(recording.events())[1:]
    return [list(group) for _, group in itertools.groupby(events, key=lambda event: event.utime)]


def bare_loop(ticks: Sequence[Sequence[Event]], log: Path) -> list[float]:
    """Return the seconds of each tick of the bare loop: publish, receive and log every message."""
    bus = lcm.LCM("memq://")
    event_log = lcm.EventLog(str(log), "w", overwrite=True)
    stamp = 0

    def receive(channel: str, data: bytes) -> None:
        event_log.write_event(stamp, channel, data)

    for channel in {event.channel for tick in ticks for event in tick}:
        bus.subscribe(channel, receive)
    durations = []
    for tick in ticks:
        begin = time.perf_counter()
        for event in tick:
            stamp = event.utime
            bus.publish(event.channel, event.data)
            bus.handle()
        durations.append(time.perf_counter() - begin)
    event_log.close()
    return durations


def framework(log: Path, ticks: int, *, tapped: bool) -> list[float]:
    """Return the seconds of each tick of the runner that are not spent in ``step``."""
    graph = load_graph(GRAPH, Catalog())
    stages = graph.make_stages()
    writer = LogWriter(log)
    tap = Tap("thin", "bench", TAP_URL) if tapped else None
    sinks: dict[str, Sink] = {"log": writer} | ({"tap": tap} if tap else {})
    runner = Runner(graph, stages, Bus("memq://"), sinks)
    runner.reset(SEED)
    units = runner.units.values()
    beyond = []
    for _ in range(ticks):
        inside = sum(unit.durations.total_s for unit in units)
        begin = time.perf_counter()
        runner.tick()
        wall_s = time.perf_counter() - begin
        beyond.append(wall_s - (sum(unit.durations.total_s for unit in units) - inside))
    writer.close()
    if tap:
        tap.close()
    runner.close()
    return beyond


def measure(repeats: int = 5, until_s: float = 15.0) -> dict[str, float]:
    """Return medians in ms and their ratios: runner, runner with tap, bare loop."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        graph = load_graph(GRAPH, Catalog(), sets=[f"run.until_s={until_s}", f"run.seed={SEED}"])
        run_recorded(graph, graph.make_stages(), folder)
        ticks = ticks_of(folder / LOG)
        rows: dict[str, list[float]] = {"runner": [], "tapped": [], "bare": []}
        for _ in range(repeats):
            for name, log in (("runner", "a"), ("bare", "b"), ("tapped", "c")):
                gc.collect()
                if name == "bare":
                    durations = bare_loop(ticks, folder / log)
                else:
                    durations = framework(folder / log, len(ticks) - 1, tapped=name == "tapped")
                rows[name].append(statistics.median(durations[2:]))
        kilobytes = statistics.median(sum(len(event.data) for event in tick) for tick in ticks) / 1e3
    medians = {name: statistics.median(values) * 1e3 for name, values in rows.items()}
    return {
        "kB a tick": kilobytes,
        "bare loop, ms": medians["bare"],
        "beyond the steps, ms": medians["runner"],
        "beyond the steps / bare loop": medians["runner"] / medians["bare"],
        "with the tap / without": medians["tapped"] / medians["runner"],
    }


if __name__ == "__main__":
    for figure, value in measure().items():
        print(f"{figure:32} {value:8.3f}")
