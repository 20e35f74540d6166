"""It sees: detectors beside their twins on true flow, on frames that drives by the truth gave."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
from graphnav_score.plane import Plane

from acceptance.drives import say
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, parse_override
from graphnav.core.runner.recording.run_recorded import run_recorded

Scores = dict[str, Plane]

DETECTORS = ("ica", "affine", "homography", "residual")
METRICS = (
    "auroc",
    "iou_ratio",
    "balanced_accuracy_ratio",
    "recall_at_5_false_alarms_ratio",
    "false_obstacle_ratio",
    "flicker_ratio",
)
CORRIDOR_MAPS = ("maps/corridor_ccw.yaml", "maps/corridor_cw.yaml")
EMPTY_MAP = "maps/empty.yaml"
TARGETS = {("ica", "auroc"): 0.90, ("ica", "iou_ratio"): 0.45, ("residual", "auroc"): 0.93}
MAX_FALSE = 0.01
DRAWS = 1000


def sees_item(seeds: Sequence[int], jobs: int) -> bool:
    """Print every detector's metrics over both corridors, all frames pooled, beside those of its twin.

    The 95 % intervals are bootstrapped over drives, because frames of one drive are not independent.
    """
    drives = _measure([(path, seed, None) for path in CORRIDOR_MAPS for seed in seeds], jobs)
    passed = True
    for detector in DETECTORS:
        own = [scores[f"{detector}_score"] for scores in drives]
        twin = pooled([scores[f"{detector}_twin_score"] for scores in drives]).summary()
        metrics = pooled(own).summary()
        say(f"     {detector}: {metrics['frames']:.0f} frames of {len(drives)} drives")
        for metric in METRICS:
            low, high = bootstrap(own, metric)
            target = TARGETS.get((detector, metric))
            good = target is None or metrics[metric] >= target
            passed &= good
            mark = "    " if target is None else "ok  " if good else "MISS"
            wanted = "" if target is None else f", at least {target:g}"
            say(f"{mark}   {metric:31} {metrics[metric]:.3f} [{low:.3f}, {high:.3f}]{wanted}; twin {twin[metric]:.3f}")
    return passed


def floor_item(seeds: Sequence[int], jobs: int) -> bool:
    """Print the share of an empty floor that each detector calls obstacle, and that each twin does.

    The robot wanders at random there, turns included.
    """
    drives = _measure([(EMPTY_MAP, seed, 20.0) for seed in seeds], jobs)
    passed = True
    for name in [f"{detector}{twin}_score" for detector in DETECTORS for twin in ("", "_twin")]:
        own = [scores[name] for scores in drives]
        value = pooled(own).summary()["false_obstacle_ratio"]
        low, high = bootstrap(own, "false_obstacle_ratio")
        judged = "twin" not in name
        good = value <= MAX_FALSE or not judged
        passed &= good
        mark = ("ok  " if good else "MISS") if judged else "    "
        say(f"{mark} {name:20} false obstacle {value:.4f} [{low:.4f}, {high:.4f}], at most {MAX_FALSE}")
    return passed


def pooled(scores: Sequence[Plane]) -> Plane:
    """Return what all of ``scores`` counted together."""
    pooled_score = Plane()
    pooled_score.reset(0)
    for score in scores:
        pooled_score.merge(score)
    return pooled_score


def bootstrap(scores: Sequence[Plane], metric: str) -> tuple[float, float]:
    """Return the 95 % percentile interval of a pooled metric over draws of drives (seed 0)."""
    rng = np.random.default_rng(0)
    values = []
    for _ in range(DRAWS if metric not in {"auroc", "recall_at_5_false_alarms_ratio"} else DRAWS // 10):
        drawn = pooled([scores[k] for k in rng.integers(0, len(scores), len(scores))]).summary()
        if metric in drawn:
            values.append(drawn[metric])
    return float(np.quantile(values, 0.025)), float(np.quantile(values, 0.975))


def _measure(tasks: Sequence[tuple[str, int, float | None]], jobs: int) -> list[Scores]:
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        return list(pool.map(_drive, tasks))


def _drive(task: tuple[str, int, float | None]) -> Scores:
    """Run ``measure_detectors`` once and return its score stages."""
    path, seed, until_s = task
    sets = [f"robot.map={path}", f"run.seed={seed}"]
    if until_s is not None:
        sets += [f"run.until_s={until_s}"]
    if path == EMPTY_MAP:
        sets += ["control=control.wander"]
    graph = load_graph("measure_detectors", Catalog(), [*map(parse_override, sets)])
    stages = graph.make_stages()
    with tempfile.TemporaryDirectory() as scratch:
        summary = run_recorded(graph, stages, Path(scratch))
    if summary.failure:
        raise RuntimeError(summary.failure)
    return {name: stage for name, stage in stages.items() if isinstance(stage, Plane)}
