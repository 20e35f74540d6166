"""Acceptance of studies: baselines fail, oracles bound, the shipped graphs reach their goals."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from acceptance.drives import GRAPHNAV, say
from graphnav.arrays import Doubles
from graphnav.studies.ablation.results import student, wilson

Run = dict[str, str]

STUDIES = Path("ablations")
CORRIDORS = ("corridor_ccw", "corridor_cw")
DRIVES = (*CORRIDORS, "pillars")


def controls_item(seeds: Sequence[int], jobs: int) -> bool:
    """Forward and random fail, the oracle arrives, all_ground scores 0.5, the truth bounds flows and detectors."""
    steering = study("steering", seeds, jobs)
    checks = [
        *(
            _share(steering, graph, {"steer": steer}, "failed", 0.9)
            for graph in DRIVES
            for steer in ("forward", "random")
        ),
        *(_share(steering, graph, {"steer": "oracle"}, "arrived", 0.98) for graph in DRIVES),
    ]
    detectors = study("detectors", seeds, jobs)
    at = {"planar": "planar.motion"}
    for graph in DRIVES:
        found = sorted(set(_metrics(detectors, graph, {**at, "plane": "plane.all_ground"}, "sight.auroc").tolist()))
        checks.append(_said(f"{graph}: plane.all_ground scores AUROC {found}, exactly 0.5", good=found == [0.5]))
        prior = _metrics(detectors, graph, {**at, "plane": "plane.row_prior"}, "sight.auroc")
        say(f"     {graph}: plane.row_prior scores AUROC {np.mean(prior):.3f} (the prior's)")
        for plane in _values(detectors, "plane") - {"plane.truth"}:
            for metric in ("sight.auroc", "drive.success"):
                bound = _metrics(detectors, graph, {**at, "plane": "plane.truth"}, metric)
                other = _metrics(detectors, graph, {**at, "plane": plane}, metric)
                checks.append(_bounded(f"{graph}: {metric} of {plane}", other, bound))
    flows = study("flows", seeds, jobs)
    for speed in sorted(_values(flows, "speed")):
        for flow in sorted(_values(flows, "flow") - {"truth"}):
            for metric, sign in (("sense.epe_px", -1.0), ("residual_sight.auroc", 1.0)):
                bound = _metrics(flows, "measure_flow", {"speed": speed, "flow": "truth"}, metric)
                other = _metrics(flows, "measure_flow", {"speed": speed, "flow": flow}, metric)
                checks.append(_bounded(f"{speed}: {metric} of {flow}", sign * other, sign * bound))
    return all(checks)


def targets_item(seeds: Sequence[int], jobs: int) -> bool:
    """Drive corridors and pillars, with odometry and without, no worse than the truth drives them."""
    runs = study("detectors", seeds, jobs)
    checks = []
    for planar in ("planar.motion", "planar.subspace"):
        chosen = {"plane": "plane.ica", "planar": planar}
        for graph in DRIVES:
            checks.append(_share(runs, graph, chosen, "arrived", 0.9 if graph == "pillars" else 0.98))
            truth = _metrics(runs, graph, {"plane": "plane.truth", "planar": "planar.motion"}, "drive.success")
            checks.append(_bounded(f"{graph}: plane.truth", truth, _metrics(runs, graph, chosen, "drive.success")))
    return all(checks)


def study(name: str, seeds: Sequence[int], jobs: int) -> list[Run]:
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


def _share(runs: Iterable[Run], graph: str, labels: dict[str, str], what: str, min_share: float) -> bool:
    """Report the number of worlds in which the drive arrived without contact, or failed to."""
    who = f"{graph}: {' + '.join(labels.values())}"
    ends = [run["outcome"] == "goal" for run in _chosen(runs, graph, labels)]
    if not ends:
        return _said(f"{who}: there is no run", good=False)
    count = sum(ends) if what == "arrived" else len(ends) - sum(ends)
    low, high = wilson(count, len(ends))
    text = f"{who} {what} in {count} of {len(ends)} worlds [{low:.2f}, {high:.2f}], at least {min_share:g}"
    return _said(text, good=count >= min_share * len(ends))


def _bounded(what: str, values: Doubles, bound: Doubles) -> bool:
    """Say whether the paired difference from what bounds it is not plainly above zero (95 %, Student over worlds)."""
    difference = (values - bound)[~np.isnan(values - bound)]
    if not len(difference):
        return _said(f"{what}: no world has the metric", good=False)
    low, high = student(difference)
    return _said(f"{what} minus its bound: {difference.mean():+.4f} [{low:+.4f}, {high:+.4f}]", good=low <= 0.0)


def _said(text: str, *, good: bool) -> bool:
    say(f"{'ok  ' if good else 'MISS'} {text}")
    return good
