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
from dataclasses import dataclass, field
from pathlib import Path

import bench_ablate
from testbed.drives import GRAPHNAV

from tests.targets import Targets

DASK = Path(sysconfig.get_path("scripts")) / "dask"
KILLS = 5
WORLDS = 12
GROWING_WORLDS = 20
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
    with _cluster(tmp_path, "first", "second") as workers:
        cluster = _finish(tmp_path / "cluster", seeds, "--cluster", workers.address)
    text = f"results.csv with -j 1, -j 2, Dask with 2 workers: -j 2 {one == two}, Dask {one == cluster}"
    targets.check(text, good=one == two == cluster)


def test_workers_come_and_go(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Three workers, of which one is killed while it drives, and a fourth that comes: the results of one machine."""
    one = _finish(tmp_path / "one", seeds, "-j", "1", worlds=GROWING_WORLDS)
    out = tmp_path / "cluster"
    with _cluster(tmp_path, "first", "second", "third") as workers:
        study = _start(out, seeds, "--cluster", workers.address, worlds=GROWING_WORLDS)
        n_killed = _wait_for_runs(out, 10, study)
        os.killpg(workers.processes["second"].pid, signal.SIGKILL)
        n_come = _wait_for_runs(out, n_killed + 10, study)
        workers.start("fourth")
        status = study.wait()
    same = (out / "results.csv").read_bytes() == one
    when = f"killed by -9 after {n_killed} of {len(one.splitlines()) - 1} runs, one added after {n_come}"
    text = f"a worker of three {when}: results.csv has {'the same' if same else 'other'} bytes as of one machine"
    targets.check(text, good=status == 0 and same)


def _wait_for_runs(folder: Path, n_runs: int, study: subprocess.Popen[bytes]) -> int:
    """Wait until a study has made so many runs, and return how many; it must not have ended by then."""
    while (made := len(list(folder.glob("runs/*/*/*/summary.json")))) < n_runs:
        assert study.poll() is None, "the study ended before a worker could be killed"
        time.sleep(0.1)
    return made


def test_parallel_efficiency(targets: Targets) -> None:
    found = bench_ablate.measure()
    text = f"parallel efficiency on 2 cores {found['efficiency']:.2f}, at least {MIN_EFFICIENCY}: "
    text += f"{found['-j 1, s']:.1f} s with one process, {found['-j 2, s']:.1f} s with two"
    targets.check(text, good=found["efficiency"] >= MIN_EFFICIENCY)


def _start(folder: Path, seeds: Sequence[int], *words: str, worlds: int = WORLDS) -> subprocess.Popen[bytes]:
    numbers = ",".join(map(str, seeds[:worlds]))
    command = [str(GRAPHNAV), "ablate", *STUDY, "--seeds", numbers, "-o", str(folder), *words]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, start_new_session=True)


def _finish(folder: Path, seeds: Sequence[int], *words: str, worlds: int = WORLDS) -> bytes:
    if status := _start(folder, seeds, *words, worlds=worlds).wait():
        raise RuntimeError(f"graphnav ablate {' '.join(words)} ended with {status}")
    return (folder / "results.csv").read_bytes()


@dataclass
class Workers:
    """A Dask scheduler on loopback and its workers by name, each in a session of its own with what watches over it."""

    stack: ExitStack
    scratch: Path
    address: str = ""
    processes: dict[str, subprocess.Popen[str]] = field(default_factory=dict)

    def start(self, name: str) -> None:
        """Start a worker, which joins the scheduler by itself."""
        folder = str(self.scratch / name)
        self.processes[name] = self.launch("worker", self.address, "--nthreads", "1", "--local-directory", folder)
        _read_on(self.processes[name])

    def launch(self, *words: str) -> subprocess.Popen[str]:
        """Start a part of Dask that ends with the test."""
        process = self.stack.enter_context(
            subprocess.Popen(
                [str(DASK), *words, "--no-dashboard"], stderr=subprocess.PIPE, text=True, start_new_session=True
            )
        )
        self.stack.callback(process.terminate)
        return process


@contextmanager
def _cluster(scratch: Path, *names: str) -> Iterator[Workers]:
    """Start a Dask scheduler and workers on loopback."""
    with ExitStack() as stack:
        workers = Workers(stack, scratch)
        scheduler = workers.launch("scheduler", "--host", "127.0.0.1", "--port", "0")
        assert scheduler.stderr is not None
        workers.address = next(found[0] for line in scheduler.stderr if (found := re.search(r"tcp://[\d.]+:\d+", line)))
        _read_on(scheduler)
        for name in names:
            workers.start(name)
        yield workers


def _read_on(process: subprocess.Popen[str]) -> None:
    """Read what a process prints, so that it never waits for that."""
    assert process.stderr is not None
    threading.Thread(target=process.stderr.read, daemon=True).start()
