"""Memory, open files and threads of programs that run for a long time."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from statistics import median
from typing import NamedTuple

import pytest
from testbed.drives import GRAPHNAV

from graphnav.core.catalog import Catalog
from graphnav.core.graph import load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import RunningRun
from graphnav.processes.running_runs import processes_of
from tests.processes.conftest import wait_until
from tests.targets import Targets

HOUR_S = 3600.0
_LOCKSTEP, _LIVE = "udpm://239.255.97.1:7697?ttl=0", "udpm://239.255.97.2:7698?ttl=0"
_PERIOD_S = 5.0
_MAX_RATIO, _MAX_MORE_MB = 1.03, 5.0
_MAP = "maps/suite/laps.yaml"
_ENDLESS = ("--until", "100000", "--no-pictures")
_ROBOT = ("run", "robot_live", "--set", f"robot.map={_MAP}", *_ENDLESS)
_LONG = ("--set", "drive.duration_s=100000", "--set", "run.record=small")
_LAPS = ("run", "navigate/laps", "--pace", "1", *_LONG, *_ENDLESS)
_SETTLE_S = 15.0
"""Until helpers that start with the first message of their kind are there."""


class Size(NamedTuple):
    """Resident memory, open file descriptors and threads of a process."""

    memory_mb: float
    files: int
    threads: int


class Program(NamedTuple):
    """A process that is watched for some time from the start of all."""

    name: str
    pid: int
    lasts_s: float
    sizes: list[Size]


def test_soak(targets: Targets, tmp_path: Path) -> None:
    """How programs grow: a lockstep run with its tap and a spy in an hour, a live pair in half an hour."""
    with ExitStack() as ending:
        _watch(programs := list(_programs(tmp_path, ending)), HOUR_S)
    for program in programs:
        _judge(targets, program)


@pytest.mark.parametrize("mode", ["lockstep", "live"])
def test_soak_over_processes(targets: Targets, minutes: float, tmp_path: Path, mode: str) -> None:
    """How a run over processes grows in ``--minutes``: its own process, those of its stages, and its helpers."""
    lasts_s, folder = 60.0 * minutes, tmp_path / "run"
    with ExitStack() as ending:
        if mode == "live":
            _begun(ending, "live robot", lasts_s, _LIVE, *_ROBOT, "-o", str(tmp_path / "robot"))
            words = ("run", "navigate_robot", *_ENDLESS)
            run = _begun(ending, "live run", lasts_s, _LIVE, *words, "--processes", "-o", str(folder))
        else:
            run = _begun(ending, "lockstep run", lasts_s, _LOCKSTEP, *_LAPS, "--processes", "-o", str(folder))
        wait_until((folder / RunFolder.LOG).exists)
        begin_s = time.monotonic()
        while len(_children(folder)) < len(_stages(folder)) or time.monotonic() - begin_s < _SETTLE_S:
            time.sleep(_PERIOD_S)
        programs = [run, *(Program(name, pid, lasts_s, []) for pid, name in _children(folder).items())]
        _watch(programs, lasts_s)
    for program in programs:
        _judge(targets, program)


def _stages(folder: Path) -> list[str]:
    """Return the stages of the run in a folder."""
    return [node.name for node in load_graph(folder / RunFolder.GRAPH, Catalog()).nodes]


def _children(folder: Path) -> dict[int, str]:
    """Return the processes that the run in a folder has started, and what they are."""
    (run,) = [run for run in RunningRun.all() if run.folder == folder]
    children = Path(f"/proc/{run.pid}/task").glob("*/children")
    named = {int(pid): "helper of the run" for file in children for pid in file.read_text().split()}
    return named | {process.pid: f"process '{process.name}'" for process in processes_of(run)}


def _watch(programs: Sequence[Program], for_s: float) -> None:
    """Note the sizes of programs again and again."""
    begin_s = time.monotonic()
    while (elapsed_s := time.monotonic() - begin_s) < for_s:
        for program in programs:
            if elapsed_s < program.lasts_s:
                program.sizes.append(_size(program.pid))
        time.sleep(_PERIOD_S)


def _programs(scratch: Path, ending: ExitStack) -> Iterator[Program]:
    """Start the programs; yield them."""
    yield _begun(ending, "lockstep run with tap", HOUR_S, _LOCKSTEP, *_LAPS, "-o", str(scratch / "lockstep"))
    yield _begun(ending, "spy", HOUR_S, _LOCKSTEP, "spy")
    half_s = HOUR_S / 2
    yield _begun(ending, "live robot", half_s, _LIVE, *_ROBOT, "-o", str(scratch / "robot"))
    driver = ("run", "navigate_robot", *_ENDLESS, "-o", str(scratch / "driver"))
    yield _begun(ending, "live driver", half_s, _LIVE, *driver)


def _begun(ending: ExitStack, name: str, lasts_s: float, url: str, *words: str) -> Program:
    """Start a program."""
    around = os.environ | {"LCM_DEFAULT_URL": url}
    start = _in_terminal if words[0] == "spy" else _process
    return Program(name, ending.enter_context(start([str(GRAPHNAV), *words], around)), lasts_s, [])


def _judge(targets: Targets, program: Program) -> None:
    """Print the sizes of a program after a tenth of its time and at its end; check that they are the same."""
    n_later = len(program.sizes) // 10
    if not n_later or program.sizes[-1].memory_mb == 0.0:
        text = f"{program.name}: ended early, after {_PERIOD_S * len(program.sizes):.0f} s at most"
        targets.check(text, good=False)
        return
    begin, end = program.sizes[n_later : 2 * n_later], program.sizes[-n_later:]
    memory_mb = [median(size.memory_mb for size in part) for part in (begin, end)]
    files = [max(size.files for size in part) for part in (begin, end)]
    threads = [max(size.threads for size in part) for part in (begin, end)]
    is_flat = memory_mb[1] <= memory_mb[0] * _MAX_RATIO + _MAX_MORE_MB and files[1] <= files[0]
    is_flat = is_flat and threads[1] <= threads[0]
    targets.check(
        f"{program.name}, {program.lasts_s / 60:.0f} min: memory {memory_mb[0]:.1f} to {memory_mb[1]:.1f} MB, files "
        f"{files[0]} to {files[1]}, threads {threads[0]} to {threads[1]} (from the second to the last tenth of the "
        "time)",
        good=is_flat,
    )


def _size(pid: int) -> Size:
    """Return the size of a process, 0 of one that has ended."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
        files = len(os.listdir(f"/proc/{pid}/fd"))
    except OSError:
        return Size(0.0, 0, 0)
    memory, threads = (re.search(rf"^{name}:\s+(\d+)", status, re.MULTILINE) for name in ("VmRSS", "Threads"))
    return Size(int(memory[1]) / 1024 if memory else 0.0, files, int(threads[1]) if threads else 0)


@contextmanager
def _process(words: list[str], environment: Mapping[str, str]) -> Iterator[int]:
    """Run a command without a terminal; yield its process."""
    process = subprocess.Popen(
        words,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=environment,
    )
    with _ended(process):
        yield process.pid


@contextmanager
def _in_terminal(words: list[str], environment: Mapping[str, str]) -> Iterator[int]:
    """Run a command in a terminal that is read but not shown; yield its process."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen(
        words, stdin=theirs, stdout=theirs, stderr=theirs, env={**environment, "TERM": "xterm-256color"}
    )
    os.close(theirs)

    def read() -> None:
        with suppress(OSError):
            while os.read(ours, 65536):
                pass

    threading.Thread(target=read, daemon=True).start()
    with _ended(process):
        yield process.pid
    os.close(ours)


@contextmanager
def _ended(process: subprocess.Popen[bytes]) -> Iterator[None]:
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
