"""Benchmark a study on two cores as a user sees it: ``-j 1``, ``-j 2`` and a Dask cluster of two workers.

With the interpreter of another version as argument, ``-j 1`` and ``-j 2`` also take turns with those of that version.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import islice
from pathlib import Path

from taking_turns import Turns, load_told, results_in_turn

STUDY = [
    *("corridor_ccw", "--vary", "plane=plane.ica,plane.affine,plane.residual"),
    *("--seeds", "0:20", "--set", "run.until_s=20", "--gallery", "0"),
]
"""60 runs of equal length, so that little time passes with one process at work at the end."""


CLUSTER = "cluster 2x1"


@dataclass(frozen=True)
class Cost:
    """Cost of a study: wall time, and processor time of all its processes but those of a cluster, in s."""

    wall_s: float
    cpu_s: float
    results: bytes
    """Its ``results.csv``."""


def measure(rounds: int = 3, old: Path | None = None) -> dict[str, float]:
    """Return medians over rounds of studies, start, tables and report included.

    ``-j 1, s`` and ``-j 2, s``: wall time; ``-j 2, cpu s``: processor time of all processes; ``efficiency``: wall time
    with one process over twice that with two; ``cluster 2x1, s`` and ``cluster efficiency``: those of a Dask cluster of
    two workers with one thread each, started before, and ``cluster results differ``: 1 if its ``results.csv`` is not
    that of ``-j 1``. With ``old``, the interpreter of a virtual environment with another
    version, also its times, ``old ...``, and ``... ratio``, its time over that of this version in the same round.
    """
    pythons = {"": Path(sys.executable)} | ({"old ": old} if old is not None else {})
    rivals = {
        f"{name}-j {jobs}": partial(_cost, python, "-j", str(jobs))
        for jobs in (1, 2)
        for name, python in pythons.items()
    }
    with cluster(2) as address:
        found = results_in_turn(rivals | {CLUSTER: partial(_cost, pythons[""], "--cluster", address)}, rounds)
    wall = Turns({name: [one.wall_s for one in costs] for name, costs in found.items()})
    cpu = Turns({name: [one.cpu_s for one in costs] for name, costs in found.items()})
    measured = {f"{name}, s": wall.median(name) for name in found}
    for name in pythons:
        measured[f"{name}-j 2, cpu s"] = cpu.median(f"{name}-j 2")
        measured[f"{name}efficiency"] = wall.ratio(f"{name}-j 1", f"{name}-j 2").median / 2
    measured["cluster efficiency"] = wall.ratio("-j 1", CLUSTER).median / 2
    measured["cluster results differ"] = float(found[CLUSTER][0].results != found["-j 1"][0].results)
    if old is not None:
        measured |= {f"-j {jobs} ratio": wall.ratio(f"old -j {jobs}", f"-j {jobs}").median for jobs in (1, 2)}
        measured["cpu ratio"] = cpu.ratio("old -j 2", "-j 2").median
    return measured


def _cost(python: Path, *where: str, study: Iterable[str] = STUDY) -> Cost:
    """Return what a study by the ``graphnav`` beside an interpreter takes; ``where``: ``-j`` or ``--cluster``."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [str(python.parent / "graphnav"), "ablate", *study, *where, "-o", f"{scratch}/study"]
        begin_s = time.perf_counter()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, used = os.wait4(process.pid, 0)
        wall_s = time.perf_counter() - begin_s
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise subprocess.CalledProcessError(process.returncode, command)
        return Cost(wall_s, used.ru_utime + used.ru_stime, Path(scratch, "study", "results.csv").read_bytes())


@contextmanager
def cluster(n_workers: int) -> Iterator[str]:
    """Yield the address of a Dask scheduler on loopback that has so many workers of one thread; all end on leaving."""
    with ExitStack() as stack:
        scratch = stack.enter_context(tempfile.TemporaryDirectory())
        scheduler = stack.enter_context(_dask("scheduler", "--host", "127.0.0.1", "--port", "0"))
        [address] = _said(scheduler, r"Scheduler at: +(tcp://[\d.]+:\d+)", 1)
        workers = ("--nworkers", str(n_workers), "--nthreads", "1", "--local-directory", scratch)
        _said(stack.enter_context(_dask("worker", address, *workers)), r"(Registered) to", n_workers)
        yield address


def _said(process: subprocess.Popen[str], pattern: str, times: int) -> list[str]:
    """Return what a part of Dask said, as soon as it has so many times; what it says later is read by a thread."""
    assert process.stderr is not None
    found = (re.search(pattern, line) for line in process.stderr)
    said = list(islice((one[1] for one in found if one), times))
    if len(said) < times:
        raise RuntimeError(f"dask ended, which was to say {pattern}")
    threading.Thread(target=process.stderr.read, daemon=True).start()
    return said


@contextmanager
def _dask(*words: str) -> Iterator[subprocess.Popen[str]]:
    """Yield a part of Dask, which ends on leaving."""
    command = [str(Path(sys.executable).parent / "dask"), *words, "--no-dashboard"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.terminate()


if __name__ == "__main__":
    with load_told():
        other = Path(sys.argv[1]) if len(sys.argv) > 1 else None
        print({name: round(value, 2) for name, value in measure(old=other).items()})
