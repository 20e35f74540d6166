"""Tune the methods of the study ``rivals`` with the same few trials each, and say which of them were best.

``python tools/tune_rivals.py [FOLDER]`` runs the trials of every method in the same four worlds, one drive each, on a
seed below 1000, and prints for each method its trials from the best to the worst: by the share of drives that arrive,
then by SPL, then by the order of the trials. The first trial of a method is how it began. The others change one
parameter each; detectors that split scores at a threshold also get their defaults. A folder that holds some of the runs
already is continued (default: ablations/rivals_tuning).
"""

from __future__ import annotations

import csv
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml  # noqa: TID251  # a study that this writes
from testbed.drives import GRAPHNAV

SEED = 300
WORLDS = ("rivals/doors", "rivals/low", "rivals/shake", "rivals/corners")
N_TRIALS = 10
TIME_S = 60
"""Of a drive: twice what the shortest path takes in the longest of these worlds."""
Settings = dict[str, Any]

_NAVIGATE = {"mad_ratio": 3, "threshold_px": 0.05, "strong_ratio": 1.6, "min_cells": 4}
_HOMOGRAPHY = {
    "plane": "plane.homography",
    "plane.in.deviation": "flow.deviation",
    **{f"plane.{name}": value for name, value in _NAVIGATE.items()},
}
_PATH = {"steer": "steer.frontier"}
_THRESHOLDS = {
    "plane.mad_ratio": (3, 2, 4, 6),
    "plane.threshold_px": (0.05, 0.08, 0.12),
    "plane.strong_ratio": (1.6, 1, 2.5),
    "plane.min_cells": (4, 1),
}
_DEFAULTS = {"plane.mad_ratio": 4, "plane.threshold_px": 0.08, "plane.strong_ratio": 1, "plane.min_cells": 1}
_OF_AFFINE = {"plane.mad_ratio": 3.5}
"""Where its default is another one."""
_DENSITIES = ((2, 1), (0.5, 0.25), (8, 4))
"""The two thresholds of the histogram, which are changed together."""

METHODS: Mapping[str, tuple[Settings, Mapping[str, Sequence[Any]]]] = {
    "homography": (_HOMOGRAPHY | _PATH, _THRESHOLDS),
    "ica": (_PATH, _THRESHOLDS),
    "one gain": ({"plane": "plane.one_gain", **_PATH}, _THRESHOLDS),
    "residual": ({"plane": "plane.residual", **_PATH}, _THRESHOLDS),
    "affine": ({"plane": "plane.affine", **_PATH}, _THRESHOLDS),
    "appearance": (
        {"plane": "plane.appearance", **_PATH},
        {
            "plane.threshold": (4, 2.5, 3, 5, 6, 8),
            "plane.window_ratio": (0.11, 0.06, 0.2),
            "plane.memory_ratio": (0.7, 0.4, 0.9),
        },
    ),
    "learned": (
        {"plane": "plane.learned", **_PATH},
        {"plane.threshold_ratio": (0.5, 0.1, 0.2, 0.3, 0.4, 0.6, 0.7, 0.8, 0.9, 0.95)},
    ),
    "frontier": (
        _HOMOGRAPHY | _PATH,
        {
            "steer.margin_m": (0.05, 0.03, 0.08),
            "steer.comfort_m": (0.25, 0.15, 0.4),
            "steer.near_cost": (1.5, 0.75, 3),
            "steer.look_ahead_m": (0.6, 0.4, 0.9),
            "steer.goal_weight": (2, 1),
        },
    ),
    "vfh": (
        {**_HOMOGRAPHY, "steer": "steer.vfh", "control.reversing": False},
        {
            "steer.margin_m": (0.05, 0.02, 0.08),
            "steer.active_m": (1, 0.7, 1.4),
            "steer.max_turn_radps": (1.2, 2),
            "steer.max_density,steer.min_density": _DENSITIES,
            "steer.goal_cost": (5, 8),
            "steer.wide_deg": (60, 90),
        },
    ),
    "dwa": (
        {**_HOMOGRAPHY, "guard.in.command": "steer.twist"},
        {
            "steer.margin_m": (0.05, 0.02),
            "steer.way_weight": (0.4, 0.1, 0.2, 0.8),
            "steer.speed_weight": (0.4, 0.1, 0.8),
            "steer.period_s": (0.25, 0.1),
            "steer.reach_m": (1, 0.6),
            "steer.unknown": ("obstacle", "free"),
        },
    ),
    "gap": (
        {**_HOMOGRAPHY, "steer": "steer.gap", "control.reversing": False},
        {
            "steer.margin_m": (0.03, 0.01, 0.06),
            "steer.max_way_m": (1, 0.7, 1.5),
            "steer.goal_cost_m": (1.5, 0.75, 3),
            "steer.change_cost_m": (0.3, 0.15),
            "steer.turn_cost_m": (0.25, 0.1),
            "steer.unknown": ("obstacle", "free"),
        },
    ),
}
"""By method: what it is, and of each parameter how it began and what else is tried."""


def trials_of(method: str) -> list[Settings]:
    """Return what each trial of a method sets of its parameters, the first as it began."""
    _, tried = METHODS[method]
    first = {name: values[0] for name, values in tried.items()}
    found = [first, *(first | {name: value} for name, values in tried.items() for value in values[1:])]
    if tried is _THRESHOLDS:
        found.append(_DEFAULTS | (_OF_AFFINE if method == "affine" else {}))
    return [_alone(one) for one in found]


def _alone(settings: Settings) -> Settings:
    """Return settings with parameters that are changed together each by itself."""
    found: Settings = {}
    for name, value in settings.items():
        names = name.split(",")
        found |= dict(zip(names, value if len(names) > 1 else [value], strict=True))
    return found


def study() -> str:
    """Return the study of all trials, YAML."""
    labels = {
        f"{method} {number}": METHODS[method][0] | trial
        for method in METHODS
        for number, trial in enumerate(trials_of(method))
    }
    content = {
        "graphs": list(WORLDS),
        "set": {"run.until_s": TIME_S, "robot.truth": False},
        "vary": {"trial": labels},
        "metrics": ["drive.success", "drive.spl"],
    }
    return yaml.safe_dump(content, sort_keys=False)


def ranked(results: Path) -> dict[str, list[tuple[float, float, int]]]:
    """Return of each method success, SPL and number of its trials, the best first."""
    found: dict[str, list[tuple[float, float]]] = defaultdict(list)
    with results.open(encoding="utf-8", newline="") as file:
        for run in csv.DictReader(file):
            found[run["trial"]].append((float(run["drive.success"] or 0), float(run["drive.spl"] or 0)))
    means = {label: [sum(column) / len(runs) for column in zip(*runs, strict=True)] for label, runs in found.items()}
    ranks = {}
    for method in METHODS:
        trials = [(*means[label], number) for number in range(N_TRIALS) if (label := f"{method} {number}") in means]
        ranks[method] = sorted(trials, key=lambda trial: (-trial[0], -trial[1], trial[2]))
    return ranks


def main() -> None:
    """Run the trials and print what came of them."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "ablations/rivals_tuning")
    folder.parent.mkdir(parents=True, exist_ok=True)
    path = folder.with_suffix(".yaml")
    path.write_text(study(), encoding="utf-8")
    command = [str(GRAPHNAV), "ablate", str(path), "--seeds", f"{SEED}:{SEED + 1}", "-o", str(folder), "--gallery", "0"]
    subprocess.run([*command, "--yes"], check=True, stdout=subprocess.DEVNULL)
    for method, trials in ranked(folder / "results.csv").items():
        print(method)
        for success, spl, number in trials:
            print(f"  {success:.2f} {spl:.3f}  {trials_of(method)[number]}")


if __name__ == "__main__":
    main()
