"""It sees: detectors beside their twins on true flow, on frames that drives by the truth gave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acceptance.drives import drive_all, say

DETECTORS = ("ica", "affine", "residual")
FIGURES = ("auroc", "iou", "balanced_accuracy", "recall_at_5_percent", "flicker_ratio")
CORRIDOR_MAPS = ("maps/corridor_ccw.yaml", "maps/corridor_cw.yaml")
EMPTY_MAP = "maps/empty.yaml"
TARGETS = {("ica", "auroc"): 0.90, ("ica", "iou"): 0.45, ("residual", "auroc"): 0.93}
MOST_FALSE = 0.01


def sees_item(seeds: Sequence[int], jobs: int) -> bool:
    """Print every detector's figures over the corridors, means with 95 % bootstrap intervals, beside its twin's."""
    summaries = [
        summary
        for path in CORRIDOR_MAPS
        for summary in drive_all("measure_detectors", seeds, (f"robot.map={path}",), jobs).summaries
    ]
    passed = True
    for detector in DETECTORS:
        for figure in FIGURES:
            own = [s["scores"][f"{detector}_score"].get(figure) for s in summaries]
            twin = [s["scores"][f"{detector}_twin_score"].get(figure) for s in summaries]
            if None in own or None in twin:
                continue
            mean, low, high = bootstrap_mean(own)
            target = TARGETS.get((detector, figure))
            good = target is None or mean >= target
            passed &= good
            mark = "    " if target is None else "ok  " if good else "MISS"
            wanted = "" if target is None else f", at least {target:g}"
            relative = f"twin {np.mean(twin):.3f}"
            say(f"{mark} {detector:9} {figure:20} {mean:.3f} [{low:.3f}, {high:.3f}]{wanted}; {relative}")
    return passed


def floor_item(seeds: Sequence[int], jobs: int) -> bool:
    """Print the share of an empty floor that each detector calls obstacle."""
    drives = drive_all("measure_detectors", seeds, (f"robot.map={EMPTY_MAP}", "run.until_s=20"), jobs)
    passed = True
    for detector in DETECTORS:
        mean, low, high = bootstrap_mean(drives.figures(f"{detector}_score", "false_obstacle_ratio"))
        good = mean <= MOST_FALSE
        passed &= good
        say(f"{'ok  ' if good else 'MISS'} {detector:9} false obstacle {mean:.4f} [{low:.4f}, {high:.4f}]")
    return passed


def bootstrap_mean(values: Sequence[float], draws: int = 10_000) -> tuple[float, float, float]:
    """Return the mean and its 95 % percentile bootstrap interval (seed 0)."""
    array = np.asarray(values, dtype=float)
    means = np.random.default_rng(0).choice(array, (draws, len(array))).mean(axis=1)
    return float(array.mean()), float(np.quantile(means, 0.025)), float(np.quantile(means, 0.975))
