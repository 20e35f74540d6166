"""Studies: they survive being killed, and come to the same however they are made."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import sysconfig
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

import bench_ablate
from testbed.drives import GRAPHNAV

from tests.targets import Targets

DASK = Path(sysconfig.get_path("scripts")) / "dask"
KILLS = 5
WORLDS = 12
MIN_EFFICIENCY = 0.85
STUDY = ("corridor_ccw", "--vary", "plane=plane.ica,plane.affine,plane.truth", "--gallery", "0")


def test_kill(targets: Targets, seeds: range, jobs: int, tmp_path: Path) -> None:
    """Kill a study and all its processes five times at random moments; its results are those of an undisturbed one."""
    begin_s = time.monotonic()
    undisturbed = _finish(tmp_path / "undisturbed", seeds, "-j", str(jobs))
    wall_s = time.monotonic() - begin_s
    draw = random.Random(0)
    moments = []
    for _ in range(KILLS):
        study = _start(tmp_path / "killed", seeds, "-j", str(jobs))
        moment_s = draw.uniform(0.0, 0.3) * wall_s
        try:
            study.wait(moment_s)
        except subprocess.TimeoutExpired:
            os.killpg(study.pid, signal.SIGKILL)
            study.wait()
        made = len(list((tmp_path / "killed").glob("runs/*/*/*/summary.json")))
        moments.append(f"after {moment_s:.1f} s with {made} runs")
    good = _finish(tmp_path / "killed", seeds, "-j", str(jobs)) == undisturbed
    same = "the same bytes" if good else "other bytes"
    text = f"killed {', '.join(moments)}, then finished: results.csv has {same} as undisturbed ({wall_s:.0f} s)"
    targets.check(text, good=good)


def test_parallel(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """A study by one process, by two and by a cluster of two workers has the same results."""
    one = _finish(tmp_path / "one", seeds, "-j", "1")
    two = _finish(tmp_path / "two", seeds, "-j", "2")
    with _cluster(tmp_path) as address:
        cluster = _finish(tmp_path / "cluster", seeds, "--cluster", address)
    text = f"results.csv with -j 1, -j 2, Dask with 2 workers: -j 2 {one == two}, Dask {one == cluster}"
    targets.check(text, good=one == two == cluster)


def test_parallel_efficiency(targets: Targets) -> None:
    found = bench_ablate.measure()
    text = f"parallel efficiency on 2 cores {found['efficiency']:.2f}, at least {MIN_EFFICIENCY}: "
    text += f"{found['-j 1, s']:.1f} s with one process, {found['-j 2, s']:.1f} s with two"
    targets.check(text, good=found["efficiency"] >= MIN_EFFICIENCY)


def _start(folder: Path, seeds: Sequence[int], *words: str) -> subprocess.Popen[bytes]:
    worlds = ",".join(map(str, seeds[:WORLDS]))
    command = [str(GRAPHNAV), "ablate", *STUDY, "--seeds", worlds, "-o", str(folder), *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True)


def _finish(folder: Path, seeds: Sequence[int], *words: str) -> bytes:
    if status := _start(folder, seeds, *words).wait():
        raise RuntimeError(f"graphnav ablate {' '.join(words)} ended with {status}")
    return (folder / "results.csv").read_bytes()


@contextmanager
def _cluster(scratch: Path) -> Iterator[str]:
    """Start a Dask scheduler and two workers on loopback; yield the scheduler's address."""
    with ExitStack() as stack:
        scheduler = _dask(stack, "scheduler", "--host", "127.0.0.1", "--port", "0")
        assert scheduler.stderr is not None
        address = next(found[0] for line in scheduler.stderr if (found := re.search(r"tcp://[\d.]+:\d+", line)))
        workers = [
            _dask(stack, "worker", address, "--nthreads", "1", "--local-directory", str(scratch / name))
            for name in ("first", "second")
        ]
        for process in (scheduler, *workers):
            assert process.stderr is not None
            threading.Thread(target=process.stderr.read, daemon=True).start()
        yield address


def _dask(stack: ExitStack, *words: str) -> subprocess.Popen[str]:
    process = stack.enter_context(
        subprocess.Popen([str(DASK), *words, "--no-dashboard"], stderr=subprocess.PIPE, text=True)
    )
    stack.callback(process.terminate)
    return process
