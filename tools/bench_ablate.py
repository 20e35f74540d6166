"""Benchmark a study on two cores: wall time with ``-j 1`` and ``-j 2``, alternating, as a user sees it."""

from __future__ import annotations

import statistics
import subprocess
import sysconfig
import tempfile
import time
from pathlib import Path

GRAPHNAV = Path(sysconfig.get_path("scripts")) / "graphnav"
STUDY = ["corridor_ccw", "--vary", "plane=plane.ica,plane.affine", "--seeds", "0:12", "--set", "run.until_s=30"]
"""Runs of equal length, so that little time passes with one process at work at the end."""


def measure(rounds: int = 3) -> dict[str, float]:
    """Return medians of wall time in s, start, tables and report included, and of the rounds' efficiencies."""
    walls = [(_wall_s(1), _wall_s(2)) for _ in range(rounds)]
    one, two = zip(*walls, strict=True)
    return {
        "-j 1, s": statistics.median(one),
        "-j 2, s": statistics.median(two),
        "efficiency": statistics.median(t1 / (2 * t2) for t1, t2 in walls),
    }


def _wall_s(jobs: int) -> float:
    with tempfile.TemporaryDirectory() as scratch:
        command = [str(GRAPHNAV), "ablate", *STUDY, "-j", str(jobs), "--gallery", "0", "-o", f"{scratch}/study"]
        begin = time.perf_counter()
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
        return time.perf_counter() - begin


if __name__ == "__main__":
    print({figure: round(value, 2) for figure, value in measure().items()})
