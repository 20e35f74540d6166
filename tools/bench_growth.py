"""How the cost of a tick grows: with pixels, stages, the length of the run, obstacles, and the side of the local map.

``python tools/bench_growth.py [pixels] [stages] [length] [obstacles] [extent]`` prints these tables, without arguments
all of them. Times are processor time, so that other programs on the machine do not count.
"""

from __future__ import annotations

import json
import math
import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import cv2
from taking_turns import load_told
from threadpoolctl import threadpool_limits

from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.core.record import LogWriter
from graphnav.core.runner import Lockstep
from graphnav.core.runner.recording.kept_messages import SmallOnly

T = TypeVar("T")
SIZES = ((80, 60), (160, 120), (320, 240), (640, 480), (1280, 720))
COUNTS = (1, 3, 10, 30, 100, 300)
MINUTES = (1, 2, 5, 10, 20, 30, 40, 50, 60)
RATE_HZ = 10
OBSTACLES = (10, 30, 100, 300, 1000)
SIDES_M = (4.5, 9.0, 18.0, 36.0)
PASSING = Path(__file__).with_name("passing_stages.py")
GRAPHS = Path(__file__).resolve().parent.parent / "graphs" / "graphnav_graphs"
_WARM_UP = 5
_PIXEL_TICKS, _STAGE_TICKS, _DRIVE_TICKS = 30, 200, 100


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


def lockstep_of(
    graph: dict[str, Any], scratch: Path, *, small: bool = False, spent_s: dict[str, float] | None = None
) -> tuple[Lockstep, LogWriter]:
    """Return a run of a graph, reset, and its log; the processor time of each stage's steps is added to ``spent_s``."""
    path = scratch / "graph.yaml"
    path.write_text(json.dumps(graph))
    catalog = Catalog()
    catalog.add_file(PASSING)
    loaded = load_graph(path, catalog)
    writer = LogWriter(scratch / "run.lcmlog")
    stages = loaded.make_stages()
    if spent_s is not None:
        for name, stage in stages.items():
            timed = partial(_timed, spent_s, name, getattr(stage, "step"))  # noqa: B009 - a Stage has no step of its own
            setattr(stage, "step", timed)  # noqa: B010 - as above
    lockstep = Lockstep(loaded, stages, [SmallOnly(writer) if small else writer])
    lockstep.reset(1)
    return lockstep, writer


def _timed(spent_s: dict[str, float], name: str, step: Callable[..., T], *args: Any, **kwargs: Any) -> T:
    begin = time.process_time()
    result = step(*args, **kwargs)
    spent_s[name] = spent_s.get(name, 0.0) + time.process_time() - begin
    return result


def tick_s(lockstep: Lockstep, ticks: int) -> float:
    """Return the median processor time of a tick, s."""
    times = []
    for _ in range(ticks):
        begin = time.process_time()
        lockstep.tick()
        times.append(time.process_time() - begin)
    return statistics.median(times)


def driving_graph(scratch: Path, count: int, side_m: float) -> dict[str, Any]:
    """Return the graph `navigate`, as a robot runs it, among so many obstacles and with a local map of this side.

    The obstacles stand on a square lattice, whose side grows with their number; the goal is behind all of them.
    """
    per_side, spacing_m = math.ceil(math.sqrt(count)), 1.2
    places = [(spacing_m * (k % per_side), spacing_m * (k // per_side)) for k in range(count)]
    beyond_m = spacing_m * per_side + 1.0
    lattice = {
        "obstacles": [{"circle": {"center_m": list(at_m), "radius_m": 0.15}, "height_m": 0.4} for at_m in places],
        "start": {"at_m": [-spacing_m, -spacing_m / 2], "heading_deg": 0},
        "goal": {"circle": {"center_m": [beyond_m, beyond_m], "radius_m": 0.5}},
    }
    path = scratch / "lattice.yaml"
    path.write_text(json.dumps(lattice))
    scores = {"drive": None, "sense": None, "sight": None}
    here = {"robot": {"with": {"map": str(path)}}, "local": {"with": {"size_m": side_m}}}
    return {"extends": ["navigate"], "stages": {**scores, **here}}


def driving_ms(count: int, side_m: float) -> tuple[float, dict[str, float]]:
    """Return the median processor time of a tick of such a drive, and the mean of each stage, ms."""
    spent_s: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as scratch:
        lockstep, writer = lockstep_of(driving_graph(Path(scratch), count, side_m), Path(scratch), spent_s=spent_s)
        tick_s(lockstep, _WARM_UP)
        spent_s.clear()
        each_s = tick_s(lockstep, _DRIVE_TICKS)
        lockstep.engine.close()
        writer.close()
    return 1e3 * each_s, {name: 1e3 * total_s / _DRIVE_TICKS for name, total_s in spent_s.items()}


def obstacles() -> Iterator[str]:
    """Yield the rows of the table of numbers of obstacles in the world."""
    yield "| obstacles | ms a tick | robot, local, steer: ms |"
    yield "|---|---|---|"
    for count in OBSTACLES:
        each_ms, stages_ms = driving_ms(count, SIDES_M[1])
        shares = ", ".join(f"{stages_ms[name]:.2f}" for name in ("robot", "local", "steer"))
        yield f"| {count} | {each_ms:.2f} | {shares} |"


def extent() -> Iterator[str]:
    """Yield the rows of the table of sides of the local map; the exponent is that of the growth with its cells."""
    yield "| side of the local map, m | ms a tick | exponent | local, steer, recovery, control: ms |"
    yield "|---|---|---|---|"
    last: tuple[float, float] | None = None
    for side_m in SIDES_M:
        each_ms, stages_ms = driving_ms(OBSTACLES[2], side_m)
        exponent = "" if last is None else f"{math.log(each_ms / last[1]) / (2 * math.log(side_m / last[0])):.2f}"
        last = side_m, each_ms
        shares = ", ".join(f"{stages_ms[name]:.2f}" for name in ("local", "steer", "recovery", "control"))
        yield f"| {side_m:g} | {each_ms:.2f} | {exponent} | {shares} |"


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


TABLES = {"pixels": pixels, "stages": stages, "length": length, "obstacles": obstacles, "extent": extent}


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
    with load_told():
        main()
