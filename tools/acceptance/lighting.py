"""Light that swings: what local normalization brings, what it costs in steady light, and what it takes in time."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import bench_flow
import cv2
import numpy as np
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_score.flow import Flow
from graphnav_score.plane import Plane

from acceptance.drives import say
from acceptance.seeing import pooled
from graphnav import Stage
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, parse_override
from graphnav.core.runner.recording.run_recorded import run_recorded

Scores = dict[str, Flow | Plane]

GRAPH = Path(__file__).with_suffix(".yaml")
MAP_FOLDER = Path(__file__).parents[2] / "graphs" / "graphnav_graphs" / "maps"
MAPS = tuple(MAP_FOLDER / name for name in ("corridor_ccw.yaml", "pillars.yaml"))
DRIVES = range(4)
"""Seeds of each map: below 1000, since the window was chosen on such."""
SWING_RATIO = 0.3
DETECTORS = ("ica", "homography")
MIN_AUROC, MAX_EPE_RATIO, MAX_TIME_RATIO = 0.985, 1.05, 1.2
TIMINGS = 7


def light_item(seeds: Sequence[int], jobs: int) -> bool:  # noqa: ARG001 - every item takes both
    """AUROC in light that swings by 30 %, error in steady light, and time of a step, with and without normalization."""
    swing, steady = _measure(SWING_RATIO, jobs), _measure(0.0, jobs)
    checks = []
    for name in DETECTORS:
        on, off = _auroc(swing, f"normalized_{name}"), _auroc(swing, f"plain_{name}")
        text = f"AUROC of plane.{name}, light swings by 30 %: {on:.4f} normalized, at least {MIN_AUROC}; {off:.4f} not"
        checks.append(_said(text, good=on >= MIN_AUROC))
        on, off = _auroc(steady, f"normalized_{name}"), _auroc(steady, f"plain_{name}")
        say(f"     in steady light: {on:.4f} normalized; {off:.4f} not")
    on, off = _epe_px(steady, "normalized_flow"), _epe_px(steady, "plain_flow")
    text = f"endpoint error in steady light: {on:.4f} px normalized, {off:.4f} px not"
    checks.append(_said(f"{text}: ratio {on / off:.3f}, at most {MAX_EPE_RATIO}", good=on / off <= MAX_EPE_RATIO))
    on, off = _epe_px(swing, "normalized_flow"), _epe_px(swing, "plain_flow")
    say(f"     light swings by 30 %: {on:.4f} px normalized, {off:.4f} px not")
    for size in bench_flow.SIZES:
        ratio = _time_ratio(size)
        text = f"time of a step at {size[0]}x{size[1]}, normalized over not: {ratio:.3f}, at most {MAX_TIME_RATIO}"
        checks.append(_said(text, good=ratio <= MAX_TIME_RATIO))
    return all(checks)


def _measure(swing_ratio: float, jobs: int) -> list[Scores]:
    tasks = [(swing_ratio, path, seed) for path in MAPS for seed in DRIVES]
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        return list(pool.map(_drive, tasks))


def _drive(task: tuple[float, Path, int]) -> Scores:
    """Make one drive along a planned way and return its score stages."""
    swing_ratio, path, seed = task
    sets = (f"robot.light_swing_ratio={swing_ratio}", f"robot.map={path}", f"run.seed={seed}")
    graph = load_graph(str(GRAPH), Catalog(), [*map(parse_override, sets)])
    stages = graph.make_stages()
    with tempfile.TemporaryDirectory() as scratch:
        summary = run_recorded(graph, stages, Path(scratch))
    if summary.failure:
        raise RuntimeError(summary.failure)
    return {name: stage for name, stage in stages.items() if isinstance(stage, Flow | Plane)}


def _auroc(runs: Sequence[Scores], name: str) -> float:
    """Return the AUROC over all frames of all drives."""
    own = [scores[name] for scores in runs]
    return pooled([score for score in own if isinstance(score, Plane)]).summary()["auroc"]


def _epe_px(runs: Sequence[Scores], name: str) -> float:
    """Return the mean over drives of the endpoint error of valid vectors."""
    return float(np.mean([scores[name].summary()["epe_px"] for scores in runs]))


def _time_ratio(size: tuple[int, int]) -> float:
    """Return the ratio of the lowest medians of a step's processor time; both take turns on the same frames."""
    cv2.setNumThreads(1)
    stages: dict[str, Stage] = {"off": LucasKanade(), "on": LucasKanade(normalize_sigma_px=4.0)}
    steps = bench_flow.collect(0.0, DRIVES[:1], size=size)
    rounds = 60 * bench_flow.SIZES[0][0] // size[0]
    times = [bench_flow.step_ms(stages, steps, rounds) for _ in range(TIMINGS)]
    return min(ms["on"] for ms in times) / min(ms["off"] for ms in times)


def _said(text: str, *, good: bool) -> bool:
    say(f"{'ok  ' if good else 'MISS'} {text}")
    return good
