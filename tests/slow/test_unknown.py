"""A robot before a white wall, whose cells cannot be judged, stops or turns; elsewhere it drives as before."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from testbed.drives import drive

from graphnav import Recording
from graphnav.arrays import Doubles
from graphnav.core.messages import Truth
from tests.targets import Targets

from .conftest import DriveAll

GRAPH = "white_wall"
OFF = ("steer.unjudged=free", "guard.unjudged=ignore")
EMPTY = ("robot.map=maps/empty.yaml",)
MIN_VIEW_S = 2.0
MIN_WAY = 0.9


def test_unknown_cells_stop_or_turn_the_robot(targets: Targets, drive_all: DriveAll, seeds: range) -> None:
    drives = drive_all(GRAPH, seeds, ())
    stopped = drives.ended("timeout")
    clearance_m = min(summary["scores"]["drive"]["min_clearance_m"] for summary in drives.summaries)
    text = f"{GRAPH}: stops or turns in {stopped} of {len(seeds)}, all of them; min clearance {clearance_m:.3f} m"
    targets.check(f"{text}; {drives.outcomes()}", good=stopped == len(seeds))


def test_ignored_unknown_cells_let_it_hit_the_wall(targets: Targets, seeds: range, jobs: int, tmp_path: Path) -> None:
    """Without the policy the robot hits the wall, which is in view for 2 s and more before."""
    with ThreadPoolExecutor(jobs) as pool:
        seen_s = np.array(list(pool.map(lambda seed: _from_sight_to_contact_s(seed, tmp_path / f"{seed}"), seeds)))
    hits = int(np.count_nonzero(~np.isnan(seen_s)))
    shortest_s = float(np.nanmin(seen_s)) if hits else float("nan")
    text = f"{GRAPH}, policy off: hits the wall in {hits} of {len(seeds)}, all of them"
    text += f"; it is in view for {shortest_s:.1f} s and more before, at least {MIN_VIEW_S:g} s"
    targets.check(text, good=hits == len(seeds) and shortest_s >= MIN_VIEW_S)


def _from_sight_to_contact_s(seed: int, folder: Path) -> float:
    """Return how long the wall was in view before the contact, NaN without a contact."""
    summary = drive(GRAPH, seed, (*OFF, "run.record=all"), folder)
    if summary["outcome"] != "contact":
        return float("nan")
    with Recording(folder / "run.lcmlog") as log:
        found = ((utime, truth) for utime, _, truth in log.messages("robot.truth") if isinstance(truth, Truth))
        views = [(utime, bool(truth.obstacle.any())) for utime, truth in found]
    first = next(utime for utime, in_view in views if in_view)
    return (views[-1][0] - first) * 1e-6


def test_unknown_cells_of_an_empty_floor_cost_little_way(targets: Targets, drive_all: DriveAll, seeds: range) -> None:
    on_m, off_m = (_paths_m(drive_all, seeds, (*EMPTY, *sets)) for sets in ((), OFF))
    shares = on_m / off_m
    text = f"empty floor: {shares.min():.3f} of the way without the policy and more, mean {shares.mean():.3f}"
    targets.check(f"{text}; at least {MIN_WAY:g} in every drive", good=bool(shares.min() >= MIN_WAY))


def _paths_m(drive_all: DriveAll, seeds: range, sets: tuple[str, ...]) -> Doubles:
    drives = drive_all(GRAPH, seeds, sets)
    return np.array([summary["scores"]["drive"]["path_length_m"] for summary in drives.summaries])
