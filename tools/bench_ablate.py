"""Benchmark a study on two cores as a user sees it: ``-j 1`` and ``-j 2``, in turns with those of another version."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

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
    found: dict[str, list[float]] = {}
    for _ in range(rounds):
        one, two = ({name: _cost(python, jobs) for name, python in pythons.items()} for jobs in (1, 2))
        for name in pythons:
            _add(found, f"{name}-j 1, s", one[name].wall_s)
            _add(found, f"{name}-j 2, s", two[name].wall_s)
            _add(found, f"{name}-j 2, cpu s", two[name].cpu_s)
            _add(found, f"{name}efficiency", one[name].wall_s / (2 * two[name].wall_s))
        if old is not None:
            _add(found, "-j 1 ratio", one["old "].wall_s / one[""].wall_s)
            _add(found, "-j 2 ratio", two["old "].wall_s / two[""].wall_s)
            _add(found, "cpu ratio", two["old "].cpu_s / two[""].cpu_s)
    return {name: statistics.median(values) for name, values in found.items()}


def _add(found: dict[str, list[float]], name: str, value: float) -> None:
    found.setdefault(name, []).append(value)


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
    other = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    print({name: round(value, 2) for name, value in measure(old=other).items()})
