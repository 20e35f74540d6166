"""Acceptance of unknown cells: a robot before a white wall stops or turns, elsewhere it drives as before."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from acceptance.drives import drive, drive_all, say
from graphnav import Recording
from graphnav.arrays import Doubles
from graphnav.core.messages import Truth

GRAPH = "white_wall"
OFF = ("steer.unjudged=free", "guard.unjudged=ignore")
EMPTY = ("robot.map=maps/empty.yaml",)
MIN_VIEW_S = 2.0
MIN_WAY = 0.9


def unknown_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive at a white wall with the policy and without, and on an empty floor; print contacts and path lengths."""
    checks = [_without_contact(seeds, jobs), _baseline(seeds, jobs), _empty_floor(seeds, jobs)]
    return all(checks)


def _without_contact(seeds: Sequence[int], jobs: int) -> bool:
    drives = drive_all(GRAPH, seeds, (), jobs)
    stopped = drives.ended("timeout")
    clearance_m = min(summary["scores"]["drive"]["min_clearance_m"] for summary in drives.summaries)
    text = f"{GRAPH}: stops or turns in {stopped} of {len(seeds)}, all of them; min clearance {clearance_m:.3f} m"
    return _said(f"{text}; {drives.outcomes()}", good=stopped == len(seeds))


def _baseline(seeds: Sequence[int], jobs: int) -> bool:
    """Check that without the policy the robot hits the wall, which is in view for 2 s and more before."""
    with ThreadPoolExecutor(jobs) as pool:
        seen_s = np.array(list(pool.map(_seconds_from_sight_to_contact, seeds)))
    hits = int(np.count_nonzero(~np.isnan(seen_s)))
    if not hits:
        return _said(f"{GRAPH}, policy off: hits the wall in 0 of {len(seeds)}", good=False)
    text = f"{GRAPH}, policy off: hits the wall in {hits} of {len(seeds)}, all of them"
    shortest_s = float(np.nanmin(seen_s))
    text += f"; it is in view for {shortest_s:.1f} s and more before, at least {MIN_VIEW_S:g} s"
    return _said(text, good=hits == len(seeds) and shortest_s >= MIN_VIEW_S)


def _seconds_from_sight_to_contact(seed: int) -> float:
    """Return how long the wall was in view before the contact, NaN without a contact."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "run"
        summary = drive(GRAPH, seed, (*OFF, "run.record=all"), folder)
        if summary["outcome"] != "contact":
            return float("nan")
        with Recording(folder / "run.lcmlog") as log:
            found = ((utime, truth) for utime, _, truth in log.messages("robot.truth") if isinstance(truth, Truth))
            views = [(utime, bool(truth.obstacle.any())) for utime, truth in found]
    first = next(utime for utime, in_view in views if in_view)
    return (views[-1][0] - first) * 1e-6


def _empty_floor(seeds: Sequence[int], jobs: int) -> bool:
    on_m, off_m = (_paths_m(seeds, (*EMPTY, *sets), jobs) for sets in ((), OFF))
    shares = on_m / off_m
    text = f"empty floor: {shares.min():.3f} of the way without the policy and more, mean {shares.mean():.3f}"
    return _said(f"{text}; at least {MIN_WAY:g} in every drive", good=bool(shares.min() >= MIN_WAY))


def _paths_m(seeds: Sequence[int], sets: Sequence[str], jobs: int) -> Doubles:
    drives = drive_all(GRAPH, seeds, sets, jobs)
    return np.array([summary["scores"]["drive"]["path_length_m"] for summary in drives.summaries])


def _said(text: str, *, good: bool) -> bool:
    say(f"{'ok  ' if good else 'MISS'} {text}")
    return good
