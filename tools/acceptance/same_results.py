"""Acceptance of equal results: the shipped graphs drive and see as in the published study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from acceptance.drives import drive_all, say

SETS = ("plane=plane.ica", "run.until_s=120")
"""As in the study ``detectors``."""


@dataclass(frozen=True)
class Published:
    """The 95 % intervals of `plane.ica` in the tables of 0.1.0, over seeds 1000 to 1049, all of which arrive."""

    auroc: tuple[float, float]
    iou_ratio: tuple[float, float]


PUBLISHED = {
    "corridor_ccw": Published(auroc=(0.9870, 0.9904), iou_ratio=(0.658, 0.722)),
    "corridor_cw": Published(auroc=(0.9884, 0.9912), iou_ratio=(0.679, 0.732)),
    "pillars": Published(auroc=(0.9945, 0.9952), iou_ratio=(0.8053, 0.8229)),
}


def results_item(seeds: Sequence[int], jobs: int) -> bool:
    """Print outcomes, AUROC and IoU of three graphs, and whether they are within the published intervals."""
    passed = True
    for graph, published in PUBLISHED.items():
        drives = drive_all(graph, seeds, SETS, jobs)
        sights = [summary["scores"]["sight"] for summary in drives.summaries]
        auroc, iou = (float(np.mean([one[name] for one in sights if name in one])) for name in ("auroc", "iou_ratio"))
        good = drives.ended("goal") == len(seeds)
        for value, (low, high) in ((auroc, published.auroc), (iou, published.iou_ratio)):
            good &= low <= value <= high
        passed &= good
        say(
            f"{'ok  ' if good else 'MISS'} {graph:13} goal {drives.ended('goal')} of {len(seeds)}, all expected; AUROC "
            f"{auroc:.4f} in {list(published.auroc)}, IoU {iou:.4f} in {list(published.iou_ratio)}; {drives.outcomes()}"
        )
    return passed
