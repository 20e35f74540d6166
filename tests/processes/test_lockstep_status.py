"""The status of a lockstep run over processes, as viewers get it while ticks wait for a process, too."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from graphnav import Status
from graphnav.core.graph import Graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import run_recorded
from graphnav.processes.run import run_processes
from graphnav.processes.supervisor import Supervisor
from tests.processes.conftest import Viewer, kill, steps_graph

PARTS = "deploy: {{left: {{stages: [clock, second]}}, right: {{stages: [third], {policy}}}}}"
KILLED_US = 1_000_000


def viewed(graph: Graph, folder: Path, seen: Path) -> tuple[list[Status], bytes]:
    """Run a graph in whose process 'right' is killed, if it has any; return what a viewer saw, and the log."""
    folder.mkdir()
    viewer, supervisors, killed = Viewer(seen), list[Supervisor](), list[int]()

    def on_tick(utime: int) -> None:
        if utime >= KILLED_US and not killed:
            killed.append(utime)
            kill(supervisors[0], "right")

    if graph.deploy:
        options: dict[str, Any] = {"supervised": supervisors.append, "on_tick": on_tick, "notice": lambda _: None}
        run_processes(graph, graph.make_stages(), folder, tap=viewer, pace_ratio=1.0, **options)
    else:
        run_recorded(graph, graph.make_stages(), folder, tap=viewer, pace_ratio=1.0)
    return viewer.statuses, (folder / RunFolder.LOG).read_bytes()


def test_a_process_that_ends_before_it_was_asked_for_anything_is_restarting(tmp_path: Path) -> None:
    graph = steps_graph(tmp_path, PARTS.format(policy="restart: on_failure, restart_delay_s: 600"))
    with closing(Supervisor(graph, tmp_path, lambda _: None)) as supervisor:
        supervisor.start()
        kill(supervisor, "right")
        while not supervisor.ends["right"]:
            supervisor.wait()
        assert {one.name: one.state for one in supervisor.states()}["right"] == "restarting"


@pytest.mark.parametrize("policy", ["restart: on_failure, restart_delay_s: 2", "restart: never"])
def test_viewers_see_a_process_that_is_gone_and_the_log_does_not(tmp_path: Path, policy: str) -> None:
    seen = tmp_path / "seen"
    third = f"{{at: 0, what: meet, file: {tmp_path / 'reset'}, other: {seen}}}"  # its reset waits for what is seen
    apart, log = viewed(steps_graph(tmp_path, PARTS.format(policy=policy), third=third), tmp_path / "many", seen)
    alone, other = viewed(steps_graph(tmp_path, third=third), tmp_path / "one", seen)
    assert len(alone) >= 2
    assert {(len(status.processes), len(status.edges)) for status in alone} == {(0, 0)}
    states = [{process["name"]: process["state"] for process in status.processes} for status in apart]
    assert [*states[0]] == ["", "left", "right"]
    assert states[0]["right"] == "starting"
    assert {"never": "given up"}.get(policy.split()[1], "restarting") in {state["right"] for state in states}
    assert {edge["name"]: edge["channel"] for edge in apart[-1].edges}["third.one"] == "second.sum"
    assert not any(edge["overtaken"] for edge in apart[-1].edges)
    if policy != "restart: never":
        assert states[-1]["right"] == "ready"
        assert other == log
