"""Small obstacles and an empty floor: recall by the share of the view that is obstacle, and false obstacle."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from acceptance.drives import say
from acceptance.small_obstacles import SHARES
from graphnav.arrays import Doubles
from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph, parse_override
from graphnav.core.runner.recording.run_recorded import run_recorded
from graphnav.core.trust import Trust

GRAPH = Path(__file__).with_suffix(".yaml")
DETECTORS = {
    "reference": "plane.homography",
    "hysteresis": "plane.homography with hysteresis",
    "guided": "plane.guided_homography with hysteresis",
}
RECOMMENDED = "hysteresis"
MAX_FALSE_RATIO = 0.001
CAMERAS = {"steady camera": [], "camera shaking by 0.5 degrees": ["robot.camera_shake_deg=0.5"]}
EMPTY = [
    "robot.map=maps/empty.yaml",
    "control=control.wander",
    "control.max_speed_mps=0.3",
    "control.max_turn_radps=1.2",
]
Task = tuple[tuple[str, ...], int]
Counts = dict[str, Doubles]
"""Of each detector: false and all ground, then hit and all obstacle of each share, (2, 1 + shares)."""


def empty_floor_item(seeds: Sequence[int], jobs: int) -> bool:
    """Print false obstacle on an empty floor and recall among pillars; what was not judged counts as missed.

    The true map drives among pillars; on the empty floor the robot wanders as fast as the shipped graphs drive. The
    recommended detector may call 0.1 % of the floor obstacle and find no less than the reference does.
    """
    passed = True
    for camera, sets in CAMERAS.items():
        tasks = [((*sets, *floor), seed) for floor, seed in product(([], EMPTY), seeds)]
        with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
            drives = list(pool.map(_drive, tasks))
        ratios = {name: _ratios(sum(drive[name] for drive in drives)) for name in DETECTORS}
        say(f"     {camera}")
        for name, title in DETECTORS.items():
            false, *recalls = ratios[name]
            good = name != RECOMMENDED or bool(
                false <= MAX_FALSE_RATIO and all(a >= b for a, b in zip(recalls, ratios["reference"][1:], strict=True))
            )
            passed &= good
            mark = ("ok  " if good else "MISS") if name == RECOMMENDED else "    "
            found = ", ".join(
                f"recall {recall:.3f} of {100 * low:g} to {100 * high:g} %"
                for recall, (low, high) in zip(recalls, SHARES, strict=True)
            )
            say(f"{mark} {title:40} false obstacle {100 * false:.3f} %, {found}")
    return passed


def _ratios(counts: Any) -> list[float]:
    """Return false obstacle and the recalls; NaN where there was nothing to count."""
    part, total = counts
    return [float(value) for value in np.where(total > 0, part / np.maximum(total, 1), np.nan)]


def _drive(task: Task) -> Counts:
    """Drive once, and return what the scores counted."""
    sets, seed = task
    graph = load_graph(str(GRAPH), Catalog(Trust(runs_all=True)), [*map(parse_override, (*sets, f"run.seed={seed}"))])
    stages = graph.make_stages()
    with tempfile.TemporaryDirectory() as scratch:
        summary = run_recorded(graph, stages, Path(scratch))
    if summary.failure:
        raise RuntimeError(summary.failure)
    counts: Counts = {}
    for name in DETECTORS:
        score: Any = stages[f"{name}_score"]
        counts[name] = np.array([[score.false, *score.hit], [score.ground, *score.total]])
    return counts
