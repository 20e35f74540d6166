"""Acceptance of driving without odometry from teaching on: taught with odometry against taught from the flow alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from acceptance.drives import Drives, drive_all, say
from graphnav.studies.ablation.results import wilson

GRAPHS = ("suite/shake", "suite/odometry", "suite/light", "pillars", "corridor_ccw")
DETECTORS = ("residual", "ica")
MODELS = {"with odometry": "models/shake_160x120.lcmlog", "without": "models/components_160x120.lcmlog"}
MIN_SHARE = 0.9
"""Of the drives that succeed after teaching with odometry, those that must succeed without."""


def no_odometry_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive every world by planar.subspace with both models; print successes with 95 % intervals, and AUROC."""
    passed = True
    for graph in GRAPHS:
        for plane in DETECTORS:
            counts = []
            for name, model in MODELS.items():
                sets = (f"plane=plane.{plane}", "planar=planar.subspace", f"planar.model={model}")
                drives = drive_all(graph, seeds, sets, jobs)
                counts.append(drives.ended("goal"))
                low, high = wilson(counts[-1], len(seeds))
                share = f"{counts[-1]} of {len(seeds)} [{low:.2f}, {high:.2f}]"
                say(f"     {graph:14} {plane:8} taught {name:13} {share}, AUROC {mean_auroc(drives):.4f}")
            good = is_good(*counts)
            passed &= good
            say(f"{'ok  ' if good else 'MISS'} {graph:14} {plane:8} {counts[1]} against {counts[0]}")
    return passed


def is_good(with_odometry: int, without: int) -> bool:
    """Return whether enough drives succeed without odometry."""
    return without >= MIN_SHARE * with_odometry


def mean_auroc(drives: Drives) -> float:
    """Return the mean AUROC over the drives that met an obstacle."""
    found = [summary["scores"]["sight"].get("auroc") for summary in drives.summaries]
    return float(np.mean([auroc for auroc in found if auroc is not None] or [np.nan]))
