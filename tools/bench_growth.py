"""How the cost of a tick grows: with the pixels of the image, the number of stages, and the length of the run.

``python tools/bench_growth.py [pixels] [stages] [length]`` prints three tables, all of them without arguments.
Times are processor time, so that other programs on the machine do not count.
"""

from __future__ import annotations

import json
import math
import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
from threadpoolctl import threadpool_limits

from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.core.record import LogWriter
from graphnav.core.runner import Lockstep
from graphnav.core.runner.recording.kept_messages import SmallOnly

SIZES = ((80, 60), (160, 120), (320, 240), (640, 480), (1280, 720))
COUNTS = (1, 3, 10, 30, 100, 300)
MINUTES = (1, 2, 5, 10, 20, 30, 40, 50, 60)
RATE_HZ = 10
PASSING = Path(__file__).with_name("passing_stages.py")
GRAPHS = Path(__file__).resolve().parent.parent / "graphs" / "graphnav_graphs"
_WARM_UP = 5
_PIXEL_TICKS, _STAGE_TICKS = 30, 200


def seeing_graph(size: tuple[int, int], *, taught: bool) -> dict[str, Any]:
    """Return a graph that drives at random over boxes and looks; ``taught``: with ICA, whose model has one size."""
    plane: dict[str, Any] = {"plane": {"use": "plane.affine", "in": {"flow": "flow.flow"}}}
    if taught:
        model = {"model": str(GRAPHS / "models" / "downward_160x120.lcmlog")}
        plane = {
            "planar": {"use": "planar.motion", "with": model, "in": {"flow": "flow.flow", "motion": "robot.motion"}},
            "plane": {"use": "plane.ica", "in": {"flow": "flow.flow", "planar": "planar.planar"}},
        }
    world = {"map": str(GRAPHS / "maps" / "empty.yaml"), "size": list(size), "rate_hz": RATE_HZ}
    return {
        "stages": {
            "robot": {"use": "world.pymunk", "with": world, "in": {"command": "driver.twist"}},
            "driver": {"use": "control.wander", "in": {"image": "robot.image"}},
            "flow": {"use": "flow.lucas_kanade", "in": {"image": "robot.image"}},
            **plane,
            "steer": {"use": "steer.pca", "in": {"plane": "plane.plane"}},
        }
    }


def passing_graph(count: int, *, fans_out: bool = False) -> dict[str, Any]:
    """Return a chain of ``count`` stages that pass a command on, or as many that read that of one source."""
    stages: dict[str, Any] = {"s0": {"use": "passing.start"}}
    for k in range(1, count + 1):
        stages[f"s{k}"] = {"use": "passing.pass", "in": {"twist": f"s{0 if fans_out else k - 1}.twist"}}
    return {"stages": stages}


def message_us(scratch: Path, count: int, *, fans_out: bool = False) -> float:
    """Return the median processor time of a message of such a graph, microseconds."""
    lockstep, writer = lockstep_of(passing_graph(count, fans_out=fans_out), scratch)
    tick_s(lockstep, _WARM_UP)
    each_us = 1e6 * tick_s(lockstep, _STAGE_TICKS) / (count + 1)
    lockstep.engine.close()
    writer.close()
    return each_us


def lockstep_of(graph: dict[str, Any], scratch: Path, *, small: bool = False) -> tuple[Lockstep, LogWriter]:
    """Return a run of a graph, reset, and its log."""
    path = scratch / "graph.yaml"
    path.write_text(json.dumps(graph))
    catalog = Catalog()
    catalog.add_file(PASSING)
    loaded = load_graph(path, catalog)
    writer = LogWriter(scratch / "run.lcmlog")
    lockstep = Lockstep(loaded, loaded.make_stages(), [SmallOnly(writer) if small else writer])
    lockstep.reset(1)
    return lockstep, writer


def tick_s(lockstep: Lockstep, ticks: int) -> float:
    """Return the median processor time of a tick, s."""
    times = []
    for _ in range(ticks):
        begin = time.process_time()
        lockstep.tick()
        times.append(time.process_time() - begin)
    return statistics.median(times)


def pixels() -> Iterator[str]:
    """Yield the rows of the table of image sizes; the exponent is that of the growth since the row before."""
    yield "| image | ms a tick | ns a pixel | exponent | world, flow, plane, steer, rest: ms |"
    yield "|---|---|---|---|---|"
    last: tuple[int, float] | None = None
    for size in SIZES:
        with tempfile.TemporaryDirectory() as scratch:
            lockstep, writer = lockstep_of(seeing_graph(size, taught=False), Path(scratch))
            tick_s(lockstep, _WARM_UP)
            spent = {name: unit.durations.total_s for name, unit in lockstep.engine.units.items()}
            begin = time.perf_counter()
            each_s = tick_s(lockstep, _PIXEL_TICKS)
            mean_s = (time.perf_counter() - begin) / _PIXEL_TICKS
            spent = {n: (u.durations.total_s - spent[n]) / _PIXEL_TICKS for n, u in lockstep.engine.units.items()}
            lockstep.engine.close()
            writer.close()
        count = size[0] * size[1]
        exponent = "" if last is None else f"{math.log(each_s / last[1]) / math.log(count / last[0]):.2f}"
        last = count, each_s
        parts = [spent[name] for name in ("robot", "flow", "plane", "steer")]
        shares = ", ".join(f"{1e3 * part:.2f}" for part in [*parts, mean_s - sum(spent.values())])
        yield f"| {size[0]}x{size[1]} | {1e3 * each_s:.2f} | {1e9 * each_s / count:.0f} | {exponent} | {shares} |"


def stages() -> Iterator[str]:
    """Yield the rows of the table of numbers of stages."""
    yield "| stages | chain: us a tick | us a message | fan-out: us a tick | us a message |"
    yield "|---|---|---|---|---|"
    for count in COUNTS:
        with tempfile.TemporaryDirectory() as scratch:
            each_us = [message_us(Path(scratch), count, fans_out=fans_out) for fans_out in (False, True)]
        cells = " | ".join(f"{us * (count + 1):.0f} | {us:.1f}" for us in each_us)
        yield f"| {count} | {cells} |"


def length() -> Iterator[str]:
    """Yield the rows of the table of minutes into a run."""
    yield "| minute of the run | ms a tick | resident memory, MB |"
    yield "|---|---|---|"
    with tempfile.TemporaryDirectory() as scratch:
        lockstep, writer = lockstep_of(seeing_graph((160, 120), taught=True), Path(scratch), small=True)
        for minute in range(1, max(MINUTES) + 1):
            each_ms = 1e3 * tick_s(lockstep, 60 * RATE_HZ)
            if minute in MINUTES:
                peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
                yield f"| {minute} | {each_ms:.2f} | {peak_mb:.0f} |"
        lockstep.engine.close()
        writer.close()


TABLES = {"pixels": pixels, "stages": stages, "length": length}


def main() -> None:
    """Print the tables that are named, else all."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    for name in sys.argv[1:] or TABLES:
        for row in TABLES[name]():
            sys.stdout.write(row + "\n")
            sys.stdout.flush()
        sys.stdout.write("\n")


if __name__ == "__main__":
    main()
