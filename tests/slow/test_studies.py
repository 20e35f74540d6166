"""Shipped studies over the reporting seeds: baselines fail, oracles bound, graphs arrive where they are meant to."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from testbed.drives import GRAPHNAV

from graphnav.arrays import Doubles
from graphnav.studies.ablation.results import student, wilson
from tests.targets import Targets

Run = dict[str, str]

STUDIES = Path("ablations")
"""Below the folder in which pytest is started: runs that exist are not made again."""
DRIVES = ("corridor_ccw", "corridor_cw", "pillars")
SUITE_SHARES = {
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
"""The worlds of the suite, and the share of drives of `navigate` that have to arrive."""
MAX_AT_FAULT = 0.04
MIN_PROGRESS = 0.7


def test_controls(targets: Targets, seeds: range, jobs: int) -> None:
    """Forward and random fail, the oracle arrives, all_ground scores 0.5, the truth bounds flows and detectors."""
    steering = study("steering", seeds, jobs)
    for graph in DRIVES:
        for steer in ("forward", "random"):
            _share(targets, steering, graph, {"steer": steer}, "failed", 0.9)
        _share(targets, steering, graph, {"steer": "oracle"}, "arrived", 0.98)
    detectors = study("detectors", seeds, jobs)
    at = {"planar": "planar.motion"}
    for graph in DRIVES:
        found = sorted(set(_metrics(detectors, graph, {**at, "plane": "plane.all_ground"}, "sight.auroc").tolist()))
        targets.check(f"{graph}: plane.all_ground scores AUROC {found}, exactly 0.5", good=found == [0.5])
        prior = _metrics(detectors, graph, {**at, "plane": "plane.row_prior"}, "sight.auroc")
        targets.say(f"{graph}: plane.row_prior scores AUROC {np.mean(prior):.3f} (the prior's)")
        for plane in _values(detectors, "plane") - {"plane.truth"}:
            for metric in ("sight.auroc", "drive.success"):
                bound = _metrics(detectors, graph, {**at, "plane": "plane.truth"}, metric)
                other = _metrics(detectors, graph, {**at, "plane": plane}, metric)
                _bounded(targets, f"{graph}: {metric} of {plane}", other, bound)
    flows = study("flows", seeds, jobs)
    for speed in sorted(_values(flows, "speed")):
        for flow in sorted(_values(flows, "flow") - {"truth"}):
            for metric, sign in (("sense.epe_px", -1.0), ("residual_sight.auroc", 1.0)):
                bound = _metrics(flows, "measure_flow", {"speed": speed, "flow": "truth"}, metric)
                other = _metrics(flows, "measure_flow", {"speed": speed, "flow": flow}, metric)
                _bounded(targets, f"{speed}: {metric} of {flow}", sign * other, sign * bound)


def test_targets(targets: Targets, seeds: range, jobs: int) -> None:
    """Corridors and pillars are driven, with odometry and without, no worse than the truth drives them."""
    runs = study("detectors", seeds, jobs)
    for planar in ("planar.motion", "planar.subspace"):
        chosen = {"plane": "plane.ica", "planar": planar}
        for graph in DRIVES:
            _share(targets, runs, graph, chosen, "arrived", 0.9 if graph == "pillars" else 0.98)
            truth = _metrics(runs, graph, {"plane": "plane.truth", "planar": "planar.motion"}, "drive.success")
            _bounded(targets, f"{graph}: plane.truth", truth, _metrics(runs, graph, chosen, "drive.success"))


def test_navigate(targets: Targets, seeds: range, jobs: int) -> None:
    """The graph navigate and, in its place, the true obstacles drive every world of the suite."""
    runs = study("navigate_suite", seeds, jobs)
    for world in dict.fromkeys(run["graph"].removeprefix("navigate/") for run in runs):
        for method in ("navigate", "truth"):
            ours = [run for run in runs if run["graph"] == f"navigate/{world}" and run["method"] == method]
            if world == "laps":
                _lasts(targets, method, ours)
            else:
                _arrives(targets, world, method, ours)


def study(name: str, seeds: range, jobs: int) -> list[Run]:
    """Execute the pending runs of a shipped study and return its results."""
    folder = STUDIES / name
    span = f"{seeds[0]}:{seeds[-1] + 1}"
    command = [str(GRAPHNAV), "ablate", name, "--seeds", span, "-j", str(jobs), "-o", str(folder), "--yes"]
    subprocess.run(command, check=True, stdout=sys.stderr)
    with (folder / "results.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def _chosen(runs: Iterable[Run], graph: str, labels: dict[str, str]) -> list[Run]:
    return [r for r in runs if r["graph"] == graph and all(r[axis] == label for axis, label in labels.items())]


def _values(runs: Iterable[Run], axis: str) -> set[str]:
    return {run[axis] for run in runs}


def _metrics(runs: Iterable[Run], graph: str, labels: dict[str, str], metric: str) -> Doubles:
    """Return a metric of every world, in the order of the seeds; NaN if a run has none."""
    return np.array([float(run[metric] or "nan") for run in _chosen(runs, graph, labels)])


def _share(
    targets: Targets, runs: Iterable[Run], graph: str, labels: dict[str, str], what: str, min_share: float
) -> None:
    """Report the number of worlds in which the drive arrived without contact, or failed to."""
    who = f"{graph}: {' + '.join(labels.values())}"
    ends = [run["outcome"] == "goal" for run in _chosen(runs, graph, labels)]
    if not ends:
        targets.check(f"{who}: has not run", good=False)
        return
    count = sum(ends) if what == "arrived" else len(ends) - sum(ends)
    low, high = wilson(count, len(ends))
    text = f"{who} {what} in {count} of {len(ends)} worlds [{low:.2f}, {high:.2f}], at least {min_share:g}"
    targets.check(text, good=count >= min_share * len(ends))


def _bounded(targets: Targets, what: str, values: Doubles, bound: Doubles) -> None:
    """Check that the paired difference from what bounds it is not plainly above zero (95 %, Student over worlds)."""
    difference = (values - bound)[~np.isnan(values - bound)]
    if not len(difference):
        targets.check(f"{what}: no world has the metric", good=False)
        return
    low, high = student(difference)
    targets.check(f"{what} minus its bound: {difference.mean():+.4f} [{low:+.4f}, {high:+.4f}]", good=low <= 0.0)


def _arrives(targets: Targets, world: str, method: str, runs: Sequence[Run]) -> None:
    ends = Counter(run["outcome"] for run in runs)
    at_fault = sum(float(run["drive.at_fault"] or 0.0) for run in runs)
    goals = ends.pop("goal", 0)
    share = SUITE_SHARES.get(world, 0.0)
    good = goals >= share * len(runs) and (world != "crossers_slow" or at_fault <= MAX_AT_FAULT * len(runs))
    others = "".join(f", {end} {count}" for end, count in sorted(ends.items()))
    faults = f", of them at fault {at_fault:g}" if world.startswith("crossers") else ""
    wanted = f", at least {share:g}" if share else ""
    targets.check(f"{world}: {method} arrives in {goals} of {len(runs)}{wanted}{others}{faults}", good=good)


def _lasts(targets: Targets, method: str, runs: Sequence[Run]) -> None:
    lasted = sum(run["outcome"] != "contact" for run in runs)
    slowest = min(float(run["drive.progress_ratio"] or 0.0) for run in runs)
    targets.check(f"laps: {method} lasts without contact in {lasted} of {len(runs)}", good=lasted == len(runs))
    text = f"laps: net progress at least {slowest:.3f} of what the highest speed allows, wanted {MIN_PROGRESS:g}"
    targets.check(text, good=slowest >= MIN_PROGRESS)
