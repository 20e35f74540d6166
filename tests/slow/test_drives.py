"""Drives over the reporting seeds: detectors, the truth and the baseline, signs, published results, odometry."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from testbed.drives import Drives

from graphnav.studies.ablation.results import wilson
from tests.targets import Targets

from .conftest import DriveAll

DRAWS = 10_000
MIN_SIGN_SHARE = 0.95
CORRIDORS = ("corridor_ccw", "corridor_cw")
ROWS: list[tuple[str, tuple[str, ...], str, float]] = [
    *(
        (graph, (f"plane=plane.{plane}",), "goal", min_share)
        for graph in CORRIDORS
        for plane, min_share in (("ica", 0.95), ("affine", 0.95), ("truth", 1.0))
    ),
    ("pillars", ("plane=plane.ica",), "goal", 0.85),
    ("pillars", ("plane=plane.truth",), "goal", 1.0),
    ("approach", (), "no contact", 1.0),
    *((graph, ("steer=steer.forward",), "failure", 0.95) for graph in (*CORRIDORS, "pillars", "approach")),
]


class Published(NamedTuple):
    """The 95 % intervals of `plane.ica` in the tables of 0.1.0, over seeds 1000 to 1049, all of which arrive."""

    auroc: tuple[float, float]
    iou_ratio: tuple[float, float]


AS_PUBLISHED = ("plane=plane.ica", "run.until_s=120")
"""As in the study ``detectors``."""
PUBLISHED = {
    "corridor_ccw": Published(auroc=(0.9870, 0.9904), iou_ratio=(0.658, 0.722)),
    "corridor_cw": Published(auroc=(0.9884, 0.9912), iou_ratio=(0.679, 0.732)),
    "pillars": Published(auroc=(0.9945, 0.9952), iou_ratio=(0.8053, 0.8229)),
}

MODELS = {"with odometry": "models/shake_160x120.lcmlog", "without": "models/components_160x120.lcmlog"}
"""Models taught to planar.subspace, with odometry and from the flow alone."""
MIN_TAUGHT_SHARE = 0.9
"""Of the drives that succeed after teaching with odometry, those that must succeed without."""


@pytest.mark.parametrize(("graph", "sets", "wanted", "min_share"), ROWS)
def test_drives(
    targets: Targets,
    drive_all: DriveAll,
    seeds: range,
    graph: str,
    sets: tuple[str, ...],
    wanted: str,
    min_share: float,
) -> None:
    """The count with its 95 % interval, and the failures by seed."""
    drives = drive_all(graph, seeds, sets)
    count = succeeded(drives, wanted)
    low, high = wilson(count, len(seeds))
    text = f"{graph:13} {' '.join(sets) or 'as it ships':20} {wanted}: {count} of {len(seeds)} [{low:.2f}, {high:.2f}]"
    targets.check(f"{text}, at least {min_share:g}; {drives.outcomes()}", good=count >= round(min_share * len(seeds)))


def succeeded(drives: Drives, wanted: str) -> int:
    """Return the number of drives with the expected outcome of the row."""
    if wanted == "goal":
        return drives.ended("goal")
    if wanted == "no contact":
        return len(drives.seeds) - drives.ended("contact") - drives.ended("failed")
    return drives.ended("contact") + drives.ended("timeout")


def test_sign(targets: Targets, drive_all: DriveAll, seeds: range) -> None:
    """The share of right signs of the frames of the corridors whose obstacle is plainly on one side, pooled.

    The 95 % interval is bootstrapped over drives, because frames of one drive are not independent.
    """
    counts = []
    for graph in CORRIDORS:
        for summary in drive_all(graph, seeds, ()).summaries:
            heading = summary["scores"]["heading"]
            counts.append((heading["frames"], heading["frames"] * heading.get("right_sign_ratio", 0.0)))
    frames, right = np.array(counts).T
    share = right.sum() / frames.sum()
    drawn = np.random.default_rng(0).integers(0, len(counts), (DRAWS, len(counts)))
    shares = right[drawn].sum(axis=1) / np.maximum(frames[drawn].sum(axis=1), 1)
    low, high = np.quantile(shares, [0.025, 0.975])
    text = f"right sign in {share:.3f} [{low:.3f}, {high:.3f}] of {frames.sum():.0f} frames of {len(counts)} drives"
    n_with = np.count_nonzero(frames)
    targets.check(
        f"{text}, {n_with} of which have such frames; at least {MIN_SIGN_SHARE}", good=share >= MIN_SIGN_SHARE
    )


@pytest.mark.parametrize("graph", PUBLISHED)
def test_results(targets: Targets, drive_all: DriveAll, seeds: range, graph: str) -> None:
    """The shipped graphs drive and see as in the published study."""
    published = PUBLISHED[graph]
    drives = drive_all(graph, seeds, AS_PUBLISHED)
    sights = [summary["scores"]["sight"] for summary in drives.summaries]
    auroc, iou = (float(np.mean([one[name] for one in sights if name in one])) for name in ("auroc", "iou_ratio"))
    good = drives.ended("goal") == len(seeds)
    for value, (low, high) in ((auroc, published.auroc), (iou, published.iou_ratio)):
        good &= low <= value <= high
    text = f"{graph:13} goal {drives.ended('goal')} of {len(seeds)}, all expected; AUROC {auroc:.4f} in "
    text += f"{list(published.auroc)}, IoU {iou:.4f} in {list(published.iou_ratio)}; {drives.outcomes()}"
    targets.check(text, good=good)


@pytest.mark.parametrize("plane", ["residual", "ica"])
@pytest.mark.parametrize("graph", ["suite/shake", "suite/odometry", "suite/light", "pillars", "corridor_ccw"])
def test_no_odometry(targets: Targets, drive_all: DriveAll, seeds: range, graph: str, plane: str) -> None:
    """Taught from the flow alone planar.subspace drives nearly as well as taught with odometry."""
    counts = []
    for name, model in MODELS.items():
        sets = (f"plane=plane.{plane}", "planar=planar.subspace", f"planar.model={model}")
        drives = drive_all(graph, seeds, sets)
        counts.append(drives.ended("goal"))
        low, high = wilson(counts[-1], len(seeds))
        share = f"{counts[-1]} of {len(seeds)} [{low:.2f}, {high:.2f}]"
        targets.say(f"{graph:14} {plane:8} taught {name:13} {share}, AUROC {mean_auroc(drives):.4f}")
    good = counts[1] >= MIN_TAUGHT_SHARE * counts[0]
    targets.check(f"{graph:14} {plane:8} {counts[1]} against {counts[0]}", good=good)


def mean_auroc(drives: Drives) -> float:
    """Return the mean AUROC over the drives that met an obstacle."""
    found = [summary["scores"]["sight"].get("auroc") for summary in drives.summaries]
    return float(np.mean([auroc for auroc in found if auroc is not None] or [np.nan]))
