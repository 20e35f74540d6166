"""Where the graph navigate arrives, against what it is meant to: shares of the worlds, people and ten minutes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from acceptance.comparing import Run, study
from acceptance.drives import say

MIN_SHARES = {
    "shake": 0.9,
    "odometry": 0.96,
    "speed": 0.9,
    "corners": 0.9,
    "tight": 0.96,
    "doors": 0.9,
    "low": 0.9,
    "crossers_slow": 0.8,
    "light": 0.96,
    "neutral": 0.96,
    "corridor_ccw": 1.0,
    "corridor_cw": 1.0,
    "pillars": 1.0,
}
MAX_AT_FAULT = 0.04
MIN_PROGRESS = 0.7


def navigate_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive navigate and, in its place, the true obstacles in every world of the suite."""
    runs = study("navigate_suite", seeds, jobs)
    good = True
    for world in dict.fromkeys(run["graph"].removeprefix("navigate/") for run in runs):
        for method in ("navigate", "truth"):
            ours = [run for run in runs if run["graph"] == f"navigate/{world}" and run["method"] == method]
            good &= _lasts(method, ours) if world == "laps" else _arrives(world, method, ours)
    return good


def _arrives(world: str, method: str, runs: Sequence[Run]) -> bool:
    ends = Counter(run["outcome"] for run in runs)
    at_fault = sum(float(run["drive.at_fault"] or 0.0) for run in runs)
    goals = ends.pop("goal", 0)
    share = MIN_SHARES.get(world, 0.0)
    good = goals >= share * len(runs) and (world != "crossers_slow" or at_fault <= MAX_AT_FAULT * len(runs))
    others = "".join(f", {end} {count}" for end, count in sorted(ends.items()))
    faults = f", of them at fault {at_fault:g}" if world.startswith("crossers") else ""
    wanted = f", at least {share:g}" if share else ""
    say(f"{'ok  ' if good else 'MISS'} {world}: {method} arrives in {goals} of {len(runs)}{wanted}{others}{faults}")
    return good


def _lasts(method: str, runs: Sequence[Run]) -> bool:
    lasted = sum(run["outcome"] != "contact" for run in runs)
    slowest = min(float(run["drive.progress_ratio"] or 0.0) for run in runs)
    good = lasted == len(runs) and slowest >= MIN_PROGRESS
    mark = "ok  " if good else "MISS"
    say(f"{mark} laps: {method} lasts without contact in {lasted} of {len(runs)}")
    say(f"     net progress at least {slowest:.3f} of what the highest speed allows, wanted {MIN_PROGRESS:g}")
    return good
