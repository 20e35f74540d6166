"""Runs in several processes: the bytes of one process, what that costs, and nothing left behind, many times."""

from __future__ import annotations

import os
import random
import signal
import statistics
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from graphnav.core.catalog import Catalog
from graphnav.core.graph import Graph, load_graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Summary, run_recorded
from graphnav.processes.run import run_processes
from graphnav.processes.supervisor import Supervisor
from tests.processes.commands import Command
from tests.processes.conftest import LATE_ANSWERS, kill, restarted, wait_until
from tests.targets import Targets

GRAPHS = ("corridor_ccw", "pillars", "navigate")
N = 20
N_SEEDS = 4
UNTIL_S = 5.0
KILLED_UNTIL_S = 3.0
N_KILLS = 3
WITHIN_S = 2.0


def _run(graph: Graph, folder: Path, run: Callable[..., Summary], **options: Any) -> tuple[bytes, Summary]:
    folder.mkdir()
    summary = run(graph, graph.make_stages(), folder, **options)
    return (folder / RunFolder.LOG).read_bytes(), summary


def _graph(name: str, seed: int, until_s: float) -> Graph:
    graph = load_graph(name, Catalog())
    return replace(graph, run=replace(graph.run, seed=seed, until_s=until_s))


@pytest.mark.parametrize("name", GRAPHS)
def test_processes_give_the_bytes_of_one(targets: Targets, seeds: range, tmp_path: Path, name: str) -> None:
    n_equal, walls = 0, list[tuple[float, float]]()
    for seed in seeds[:N_SEEDS]:
        graph = _graph(name, seed, UNTIL_S)
        one, in_one = _run(graph, tmp_path / f"one{seed}", run_recorded)
        many, in_many = _run(graph.with_processes(), tmp_path / f"many{seed}", run_processes)
        n_equal += one == many and in_one.scores == in_many.scores
        walls.append((in_one.wall_s, in_many.wall_s))
    text = (
        f"{name}, {UNTIL_S:g} s, a process for each of {len(graph.nodes)} stages: {n_equal} of {len(walls)} logs equal"
    )
    targets.check(text, good=n_equal == len(walls))
    alone_s, apart_s = (statistics.median(column) for column in zip(*walls, strict=True))
    targets.say(f"  without starts, median: {alone_s:.2f} s in one process, {apart_s:.2f} s in many")


@pytest.mark.parametrize("name", GRAPHS)
def test_processes_that_answer_late_and_are_killed_give_the_same_bytes(
    targets: Targets, tmp_path: Path, name: str
) -> None:
    graph = _graph(name, 0, KILLED_UNTIL_S)
    one, _ = _run(graph, tmp_path / "one", run_recorded)
    many = restarted(replace(graph, plugins=(LATE_ANSWERS,)).with_processes())
    n_equal, n_ended, took_s = 0, 0, list[float]()
    for k in range(N):
        supervisors, ticked, drawn = list[Supervisor](), threading.Event(), random.Random(k)
        killer = threading.Thread(target=_kill_some, args=(supervisors, ticked, drawn, list(many.deploy)))
        killer.start()

        def on_tick(_: int, ticked: threading.Event = ticked) -> None:
            ticked.set()

        options = {"supervised": supervisors.append, "on_tick": on_tick, "notice": lambda _: None}
        data, summary = _run(many, tmp_path / f"many{k}", run_processes, **options)
        killer.join()
        n_equal += data == one
        n_ended += sum(len(told["ended"]) for told in (summary.processes or {}).values())
        took_s.append(summary.wall_s)
    text = f"{name}, {KILLED_UNTIL_S:g} s, answers up to 10 ms late, {n_ended} processes killed: {n_equal} of {N} equal"
    targets.check(text, good=n_equal == N and n_ended >= N)
    targets.say(f"  without starts: median {statistics.median(took_s):.1f} s, longest {max(took_s):.1f} s")


def _kill_some(supervisors: list[Supervisor], ticked: threading.Event, drawn: random.Random, names: list[str]) -> None:
    """Kill processes at random moments after the first tick, which need not be between two ticks."""
    ticked.wait()
    for _ in range(N_KILLS):
        time.sleep(drawn.uniform(0.0, 1.0))
        kill(supervisors[0], drawn.choice(names))


def _holds_something(file: Path) -> bool:
    return file.exists() and bool(file.read_text())


def _has_begun(command: Command) -> bool:
    return bool(command.others)


def _is_replaced(command: Command, warden: int) -> bool:
    return command.warden not in {None, warden}


def test_a_killed_supervisor_leaves_nothing(targets: Targets, tmp_path: Path) -> None:
    took_s, drawn = list[float](), random.Random(0)
    for k in range(N):
        folder = tmp_path / str(k)
        folder.mkdir()
        started = folder / "started"
        command = Command(folder, f"{{at: 3, what: start, file: {started}}}")
        if k % 2:  # with what left its session; the others while children import
            wait_until(partial(_holds_something, started))
        else:
            wait_until(partial(_has_begun, command))
            time.sleep(drawn.uniform(0.0, 1.0))
        command.kill()
        took_s.append(command.gone_after_s())
        command.process.communicate()
    n_good = sum(s < WITHIN_S for s in took_s)
    text = f"killed supervisors: nothing left within {WITHIN_S:g} s {n_good} of {N} times, longest {max(took_s):.2f} s"
    targets.check(text, good=n_good == N)


def test_a_killed_warden_is_replaced(targets: Targets, tmp_path: Path) -> None:
    command = Command(tmp_path, "{}")
    took_s = []
    for _ in range(N):
        wait_until(lambda: command.warden is not None)
        before = command.warden
        assert before is not None
        os.kill(before, signal.SIGKILL)
        begin_s = time.monotonic()
        wait_until(partial(_is_replaced, command, before))
        took_s.append(time.monotonic() - begin_s)
    is_running = command.process.poll() is None
    command.kill()
    gone_s = command.gone_after_s()
    command.process.communicate()
    text = f"wardens: {len(took_s)} of {N} replaced, longest {max(took_s):.2f} s; then all is gone in {gone_s:.2f} s"
    targets.check(text, good=is_running and gone_s < WITHIN_S)
