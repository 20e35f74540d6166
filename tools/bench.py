"""Benchmark every promised speed, as a ratio of medians to a named reference in the same run.

Without arguments all parts run, one after the other; PART ... runs some of them. ``--budget`` measures instead what
graphs do on a share of a core. The exit status is 1 if a limit is missed.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import bench_ablate
import bench_budget
import bench_codec
import bench_flow
import bench_render
import bench_stages
import bench_start
import bench_tick
import bench_ticks
import cv2
from reference_version import reference_python
from taking_turns import Ratio, load_told
from threadpoolctl import threadpool_limits

REPORTING_SEEDS = range(1000, 1020)


@dataclass(frozen=True)
class Judged:
    """A measured value and its limit, a maximum, or a minimum if ``at_least``; 0 or infinity where there is none."""

    name: str
    value: float | Ratio
    limit: float
    detail: str = ""
    at_least: bool = False

    @property
    def is_met(self) -> bool:
        """Whether the value is within its limit."""
        value = self.value.median if isinstance(self.value, Ratio) else self.value
        return value >= self.limit if self.at_least else value <= self.limit


def _messages() -> Iterator[Judged]:
    """Measure a tick beyond its steps against a hand-written loop, and the codec against lcm-gen's."""
    for scores in (True, False):
        tick = bench_tick.measure(scores=scores)
        name = "tick beyond the steps / hand-written loop" + ("" if scores else ", no scores")
        detail = (
            f"{tick['beyond the steps, ms']:.3f} ms against {tick['hand-written, ms']:.3f} ms for "
            f"{tick['kB a tick']:.0f} kB; bare loop {tick['bare loop, ms']:.3f} ms"
        )
        yield Judged(name, tick["ratio"], 1.3, detail)
    warm = bench_tick.measure(stepping=False)
    detail = f"{warm['beyond the steps, ms']:.3f} ms against {warm['hand-written, ms']:.3f} ms"
    yield Judged("  both without the steps between the messages", warm["ratio"], math.inf, detail)
    tapped = bench_tick.measure(tapped=True)
    yield Judged("  with the tap / without it", tapped["tap ratio"], 1.1, f"{tapped['tapped, ms']:.3f} ms with it")
    codec = bench_codec.measure(bench_codec.flow_of(480, 640), 9)
    for ours, theirs, limit in bench_codec.TARGETS:
        detail = f"ours {1e6 * codec.median(ours):.0f} us"
        yield Judged(f"{theirs} / ours, 640x480 flow", codec.ratio(theirs, ours), limit, detail, at_least=True)


def _rendering() -> Iterator[Judged]:
    """Measure the world's pictures against Farneback's flow."""
    for cols, rows, limit in ((160, 120, 0.35), (320, 240, 0.25)):
        cost = bench_render.measure(cols, rows)
        name = f"render with truth / Farneback, {cols}x{rows}"
        yield Judged(name, cost.ratio, limit, f"{cost.render_ms:.2f} ms, {cost.faces} faces in view")


def _flow() -> Iterator[Judged]:
    """Measure error and time of Lucas-Kanade against Farneback."""
    stages = bench_flow.estimators()
    both = {name: stages[name] for name in ("lucas_kanade", "farneback")}
    for turn, limit in (("straight", 0.85), ("turning", 1.0)):
        steps = bench_flow.collect(bench_flow.TURNS_RADPS[turn], REPORTING_SEEDS)
        errors = {name: bench_flow.endpoint_error_px(stage, steps) for name, stage in both.items()}
        detail = f"{errors['lucas_kanade']:.3f} px on {len(steps)} frames"
        yield Judged(
            f"Lucas-Kanade / Farneback, endpoint error, {turn}",
            errors["lucas_kanade"] / errors["farneback"],
            limit,
            detail,
        )
    for (cols, rows), limit in zip(bench_flow.SIZES, (0.35, 0.25, 0.25), strict=True):
        times = bench_flow.time_ratios((cols, rows), REPORTING_SEEDS[:2])
        detail = f"dis medium / cv2's {times['dis medium']}"
        yield Judged(f"Lucas-Kanade / Farneback, time, {cols}x{rows}", times["lucas_kanade"], limit, detail)


def _stages() -> Iterator[Judged]:
    """Measure steps of stages against version 0.1.0."""
    judged = ("plane.ica", "planar.motion", "planar.subspace")
    for name, share in bench_stages.measure(reference_python()).items():
        is_judged = name in judged or name.startswith("score.")
        yield Judged(f"{name} / that of 0.1.0, time of a step", share, 0.5 if is_judged else math.inf)


def _ticks() -> Iterator[Judged]:
    """Measure ticks per second of graphs against version 0.1.0."""
    for speed in bench_ticks.measure():
        limit = 0.0 if speed.limit is None else speed.limit
        yield Judged(f"ticks/s over those of 0.1.0, {speed.name}", speed.ratio, limit, str(speed), at_least=True)


def _studies() -> Iterator[Judged]:
    """Measure a study with two processes against one, and against version 0.1.0."""
    study = bench_ablate.measure(old=reference_python())
    detail = f"{study['-j 1, s']:.0f} s with one process, {study['-j 2, s']:.0f} s with two"
    yield Judged("a study's parallel efficiency on 2 cores", study["efficiency"], 0.95, detail, at_least=True)
    detail = f"{study['old -j 2, s']:.0f} s in 0.1.0; with one process {study['-j 1 ratio']:.2f}"
    yield Judged("a study of 60 runs: 0.1.0's time / ours, -j 2", study["-j 2 ratio"], 1.8, detail, at_least=True)


def _start() -> Iterator[Judged]:
    """Measure the start of a command against that of bare Python with numpy."""
    start = bench_start.measure()
    ours, bare = bench_start.OURS, bench_start.BARE
    yield Judged(f"{ours} / {bare}", start.ratio(ours, bare), 12, f"{1e3 * start.median(ours):.0f} ms")


PARTS: Mapping[str, Callable[[], Iterator[Judged]]] = {
    "messages": _messages,
    "rendering": _rendering,
    "flow": _flow,
    "stages": _stages,
    "ticks": _ticks,
    "studies": _studies,
    "start": _start,
}


def arguments(words: Sequence[str] | None = None) -> argparse.Namespace:
    """Return the arguments of the command line; its help lists the parts, and the benchmarks beside this one."""
    parts = "\n".join(f"  {name:10} {(part.__doc__ or '').strip()}" for name, part in PARTS.items())
    programs = (path.stem for path in sorted(Path(__file__).parent.glob("bench_*.py")))
    others = ", ".join(name for name in programs if name not in globals())
    parser = argparse.ArgumentParser(
        description=__doc__,
        epilog=f"parts:\n{parts}\n\nprograms of their own, python tools/NAME.py: {others}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("parts", nargs="*", metavar="PART", help="what to measure (default: all parts)")
    parser.add_argument("--budget", action="store_true", help="graphs on a half, a quarter and a tenth of a core")
    args = parser.parse_args(words)
    if unknown := [part for part in args.parts if part not in PARTS]:
        parser.error(f"'{unknown[0]}' is not a part; parts are {', '.join(PARTS)}")
    return args


def main() -> int:
    """Print every ratio beside its limit; return 1 if one is missed."""
    args = arguments()
    cv2.setNumThreads(1)
    threadpool_limits(1)
    with load_told():
        if args.budget:
            bench_budget.main()
            return 0
        return 1 if sum(not _told(one) for part in args.parts or PARTS for one in PARTS[part]()) else 0


def _told(one: Judged) -> bool:
    """Print a value beside its limit; return whether it is met."""
    mark = "ok  " if one.is_met else "MISS"
    bound = "" if one.limit in {0.0, math.inf} else f"at {'least' if one.at_least else 'most'} {one.limit:g}"
    value = f"{one.value}" if isinstance(one.value, Ratio) else f"{one.value:.2f}"
    sys.stdout.write(f"{mark} {one.name:62} {value:>20}  {bound:13} {one.detail}\n")
    sys.stdout.flush()
    return one.is_met


if __name__ == "__main__":
    sys.exit(main())
