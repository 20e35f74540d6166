"""Benchmark a study on two cores as a user sees it: ``-j 1`` and ``-j 2``, in turns with those of another version."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from taking_turns import Turns, load_told, results_in_turn

STUDY = [
    *("corridor_ccw", "--vary", "plane=plane.ica,plane.affine,plane.residual"),
    *("--seeds", "0:20", "--set", "run.until_s=20", "--gallery", "0"),
]
"""60 runs of equal length, so that little time passes with one process at work at the end."""


@dataclass(frozen=True)
class Cost:
    """Cost of a study: wall time, and processor time of all its processes, in s."""

    wall_s: float
    cpu_s: float


def measure(rounds: int = 3, old: Path | None = None) -> dict[str, float]:
    """Return medians over rounds of studies, start, tables and report included.

    ``-j 1, s`` and ``-j 2, s``: wall time; ``-j 2, cpu s``: processor time of all processes; ``efficiency``: wall time
    with one process over twice that with two. With ``old``, the interpreter of a virtual environment with another
    version, also its times, ``old ...``, and ``... ratio``, its time over that of this version in the same round.
    """
    pythons = {"": Path(sys.executable)} | ({"old ": old} if old is not None else {})
    rivals = {(name, jobs): partial(_cost, python, jobs) for jobs in (1, 2) for name, python in pythons.items()}
    found = results_in_turn({f"{name}-j {jobs}": rival for (name, jobs), rival in rivals.items()}, rounds)
    wall = Turns({name: [one.wall_s for one in costs] for name, costs in found.items()})
    cpu = Turns({name: [one.cpu_s for one in costs] for name, costs in found.items()})
    measured = {f"{name}, s": wall.median(name) for name in found}
    for name in pythons:
        measured[f"{name}-j 2, cpu s"] = cpu.median(f"{name}-j 2")
        measured[f"{name}efficiency"] = wall.ratio(f"{name}-j 1", f"{name}-j 2").median / 2
    if old is not None:
        measured |= {f"-j {jobs} ratio": wall.ratio(f"old -j {jobs}", f"-j {jobs}").median for jobs in (1, 2)}
        measured["cpu ratio"] = cpu.ratio("old -j 2", "-j 2").median
    return measured


def _cost(python: Path, jobs: int, study: Iterable[str] = STUDY) -> Cost:
    """Return what a study takes that the ``graphnav`` beside an interpreter makes."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [str(python.parent / "graphnav"), "ablate", *study, "-j", str(jobs), "-o", f"{scratch}/study"]
        begin_s = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - begin_s
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return Cost(wall_s, used.ru_utime + used.ru_stime)


if __name__ == "__main__":
    with load_told():
        other = Path(sys.argv[1]) if len(sys.argv) > 1 else None
        print({name: round(value, 2) for name, value in measure(old=other).items()})
