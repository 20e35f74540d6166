"""Benchmark every promised speed, as a ratio of medians to a named reference in the same run."""

from __future__ import annotations

import statistics
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import bench_ablate
import bench_codec
import bench_flow
import bench_render
import bench_start
import bench_tick
import cv2
from threadpoolctl import threadpool_limits

from graphnav.catalog import Catalog
from graphnav.graph import load_graph
from graphnav.runner.recording.run_recorded import run_recorded

REPORTING_SEEDS = range(1000, 1020)
GRAPH = "corridor_ccw"


@dataclass(frozen=True)
class Ratio:
    """A measured value and its limit: a maximum, or a minimum if ``at_least``."""

    name: str
    value: float
    limit: float
    detail: str = ""
    at_least: bool = False

    @property
    def is_met(self) -> bool:
        """Whether the value is within its limit."""
        return self.value >= self.limit if self.at_least else self.value <= self.limit


def ratios() -> Iterator[Ratio]:
    """Measure the ratios one after the other."""
    tick, tapped = bench_tick.measure(), bench_tick.measure(tapped=True)
    ours, bare = tick["beyond the steps, ms"], tick["bare loop, ms"]
    detail = f"{ours:.3f} ms against {bare:.3f} ms for {tick['kB a tick']:.0f} kB"
    yield Ratio("tick beyond the steps / bare python-lcm loop", tick["ratio"], 1.3, detail)
    yield Ratio("  the tap's share of it", tapped["ratio"] / tick["ratio"] - 1, 1.0, "cost of the tap, apart")
    encode, lcm_encode, decode, lcm_decode = bench_codec.measure(bench_codec.flow_of(480, 640), 9)
    yield Ratio("lcm-gen decode / ours, 640x480 flow", lcm_decode / decode, 50, f"ours {decode:.0f} us", at_least=True)
    yield Ratio("lcm-gen encode / ours, 640x480 flow", lcm_encode / encode, 5, f"ours {encode:.0f} us", at_least=True)
    for cols, rows in ((160, 120), (320, 240)):
        cost = bench_render.measure(cols, rows)
        name = f"render with truth / Farneback, {cols}x{rows}"
        yield Ratio(name, cost.ratio, 0.7, f"{cost.render_ms:.2f} ms, {cost.faces} faces in view")
    yield from _flow()
    start = bench_start.measure()
    yield Ratio("graphnav --help / python -c pass", start["ratio"], 12, f"{start['graphnav --help, ms']:.0f} ms")
    study = bench_ablate.measure()
    detail = f"{study['-j 1, s']:.0f} s with one process, {study['-j 2, s']:.0f} s with two"
    yield Ratio("a study's parallel efficiency on 2 cores", study["efficiency"], 0.85, detail, at_least=True)


def _flow() -> Iterator[Ratio]:
    stages = bench_flow.estimators()
    both = {name: stages[name] for name in ("lucas_kanade", "farneback")}
    for turn, limit in (("straight", 0.85), ("turning", 1.0)):
        steps = bench_flow.collect(bench_flow.TURNS_RADPS[turn], REPORTING_SEEDS)
        errors = {name: bench_flow.endpoint_error_px(stage, steps) for name, stage in both.items()}
        detail = f"{errors['lucas_kanade']:.3f} px on {len(steps)} frames"
        yield Ratio(
            f"Lucas-Kanade / Farneback, endpoint error, {turn}",
            errors["lucas_kanade"] / errors["farneback"],
            limit,
            detail,
        )
    times = bench_flow.step_ms(both, bench_flow.collect(0.0, REPORTING_SEEDS[:2]))
    detail = f"{times['lucas_kanade']:.2f} ms"
    yield Ratio("Lucas-Kanade / Farneback, time", times["lucas_kanade"] / times["cv2"], 0.7, detail)


def ticks_per_second() -> float:
    """Return the median over three runs, with log and without tap and pictures."""
    rates = []
    for _ in range(3):
        graph = load_graph(GRAPH, Catalog())
        with tempfile.TemporaryDirectory() as scratch:
            summary = run_recorded(graph, graph.make_stages(), Path(scratch))
        rates.append(summary.frames / summary.wall_s)
    return statistics.median(rates)


def main() -> int:
    """Print every ratio beside its limit; return 1 if one is missed."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    missed = 0
    for ratio in ratios():
        missed += not ratio.is_met
        mark = "ok  " if ratio.is_met else "MISS"
        bound = "at least" if ratio.at_least else "at most"
        sys.stdout.write(f"{mark} {ratio.name:52} {ratio.value:8.2f}  {bound} {ratio.limit:g}; {ratio.detail}\n")
        sys.stdout.flush()
    sys.stdout.write(f"     {GRAPH}: {ticks_per_second():.0f} ticks/s, for the record\n")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
