"""Runs some of whose processes live on another host: the same log, restarts, and who is refused."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from graphnav import UserError
from graphnav.core.graph import Graph
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import Outcome, run_recorded
from graphnav.processes.frames import Frame, Kind
from graphnav.processes.host_key import made_key
from graphnav.processes.host_link import HostListener
from graphnav.processes.host_share import HostedProcess, HostShare, serve_host
from graphnav.processes.hosts import FILE, SERVICE, hosts_of
from graphnav.processes.run import run_processes
from graphnav.processes.supervisor import Supervisor
from tests.processes.conftest import (
    PATIENCE_S,
    STAGES,
    STEPS,
    Runs,
    Viewer,
    is_alive,
    request,
    restarted,
    steps_graph,
    wait_until,
)

DEPLOY = """deploy:
  eyes: {stages: [first, second], host: jetson}
  mind: {stages: [open], host: jetson}
  hand: {stages: [both]}
"""


KEY = "state/graphnav/hosts.key"


class Share:
    """The share of one host, in a thread."""

    def __init__(self, graph: Graph, key: Path, name: str = "jetson", port: int = 0) -> None:
        self.told: list[str] = []
        self._stopping = threading.Event()
        self.listener = HostListener("127.0.0.1", port, made_key(key)[0], SERVICE, 8)
        self._share = HostShare(graph, name, self.listener, self.told.append)
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        self._share.serve(self._stopping.is_set)
        self._share.close()

    def set_clock(self, ahead_s: float) -> None:
        """Set the clock of the host, as all runs see it that are connected."""
        for one in self._share._hosted:
            one.link.wall_ns = lambda: time.time_ns() + round(ahead_s * 1e9)

    def pid_of(self, part: str) -> int:
        """Return the process of a part."""
        one = next(one for one in self._share._hosted if one.part is not None and one.part.name == part)
        assert one.running is not None
        return one.running.popen.pid

    def close(self) -> None:
        """End it."""
        self._stopping.set()
        self._thread.join()


Hosted = Callable[..., Share]


@pytest.fixture
def hosted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hosted]:
    """Return a function that starts the share of a host, and writes where it is beside the graph of the run."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    made: list[Share] = []

    def host(graph: Graph, name: str = "jetson", port: int = 0, key: str = KEY) -> Share:
        made.append(share := Share(graph, tmp_path / key, name, port))
        (tmp_path / FILE).write_text(f"hosts: {{jetson: {{address: 127.0.0.1, port: {share.listener.port}}}}}\n")
        return share

    yield host
    for one in made:
        one.close()


def alone(graph: Graph) -> Graph:
    """Return the graph in one process."""
    return replace(graph, deploy={})


def test_the_log_is_that_of_one_process(tmp_path: Path, runs: Runs, hosted: Hosted) -> None:
    graph = steps_graph(tmp_path, DEPLOY)
    share = hosted(graph)
    many = runs(graph)
    assert many.agrees_with(runs(alone(graph)))
    wait_until(lambda: sum("has ended" in line for line in share.told) == 2)


def test_a_process_that_dies_there_is_fed_again(tmp_path: Path, runs: Runs, hosted: Hosted) -> None:
    graph = restarted(steps_graph(tmp_path, DEPLOY))
    share = hosted(graph)
    killed: list[int] = []

    def kill(_: Supervisor) -> None:
        killed.append(share.pid_of("eyes"))
        os.kill(killed[-1], signal.SIGKILL)

    # the process that stands for 'hand' is killed, too, so that `killed` is called
    many = runs(graph, {1.0: "hand", 2.0: "hand"}, kill)
    assert many.agrees_with(runs(alone(graph)))
    assert len(killed) == 2
    assert not any(map(is_alive, killed))
    assert sum("process 'eyes' was killed by SIGKILL: it is started again" in line for line in many.notices) == 2


def test_a_process_that_hangs_up_is_ended(tmp_path: Path, runs: Runs, hosted: Hosted) -> None:
    graph = steps_graph(tmp_path, DEPLOY, first="{at: 3, what: shut}")
    hosted(graph)
    ran = runs(graph)
    assert "its process 'eyes' was killed by SIGKILL" in str(ran.summary.failure)


def test_a_host_that_ends_is_waited_for(tmp_path: Path, runs: Runs, hosted: Hosted) -> None:
    graph = restarted(steps_graph(tmp_path, DEPLOY))
    first = hosted(graph)
    later: list[threading.Timer] = []

    def end(_: Supervisor) -> None:
        port = first.listener.port
        first.close()
        later.append(threading.Timer(1.0, hosted, [graph], {"port": port}))
        later[0].start()

    many = runs(graph, {1.0: "hand"}, end)
    later[0].join()
    assert many.agrees_with(runs(alone(graph)))


def test_the_run_tells_the_clock_of_a_host_and_that_it_was_set(tmp_path: Path, hosted: Hosted) -> None:
    """Each of its processes there measures it; a step is told once. The log is that of one process."""
    graph = steps_graph(tmp_path, DEPLOY)
    share = hosted(graph)
    viewer, supervisors, notices, set_at = Viewer(tmp_path / "seen"), list[Supervisor](), list[str](), list[int]()

    def on_tick(utime: int) -> None:
        if utime < 1_000_000 or set_at:
            return
        set_at.append(utime)
        there = [supervisors[0].processes[name] for name in ("eyes", "mind")]
        for n_steps in (0, 1):
            wait_until(
                lambda n_steps=n_steps: (  # type: ignore[misc]
                    supervisors[0].wait(0.01)  # type: ignore[func-returns-value]
                    or all(one.clock is not None and one.clock.n_steps == n_steps for one in there)
                )
            )
            share.set_clock(3600.0)

    (tmp_path / "run").mkdir()
    options: dict[str, Any] = {"supervised": supervisors.append, "on_tick": on_tick, "notice": notices.append}
    run_processes(graph, graph.make_stages(), tmp_path / "run", tap=viewer, pace_ratio=1.0, **options)
    assert [line for line in notices if "the clock of" in line] == [
        "the clock of the host jetson was set 3600 s ahead; the run goes by its own"
    ]
    told = {one["name"]: one for one in viewer.statuses[-1].processes}
    assert {name: (one["host"], one["clock_steps"]) for name, one in told.items()} == {
        "": ("", 0),
        "eyes": ("jetson", 1),
        "mind": ("jetson", 1),
        "hand": ("", 0),
    }
    for name in ("eyes", "mind"):
        assert told[name]["round_trip_ms"] > 0
        assert abs(told[name]["clock_offset_s"] - 3600.0) <= told[name]["clock_error_s"]
    assert all(math.isnan(told["hand"][field]) for field in ("round_trip_ms", "clock_offset_s", "clock_drift_ppm"))
    summary = json.loads((tmp_path / "run" / RunFolder.SUMMARY).read_text())
    assert {name: one.get("clock_steps") for name, one in summary["processes"].items()} == {
        "eyes": 1,
        "mind": 1,
        "hand": None,
    }
    (tmp_path / "alone").mkdir()
    run_recorded(alone(graph), alone(graph).make_stages(), tmp_path / "alone")
    assert (tmp_path / "run" / RunFolder.LOG).read_bytes() == (tmp_path / "alone" / RunFolder.LOG).read_bytes()


def test_a_clock_that_the_host_itself_sends_ends_the_process(
    tmp_path: Path, runs: Runs, hosted: Hosted, monkeypatch: pytest.MonkeyPatch
) -> None:
    graph = steps_graph(tmp_path, DEPLOY)
    hosted(graph)

    def lie(_: HostShare, one: HostedProcess, frame: Frame) -> None:
        one.link.send(Frame(Kind.CLOCK, [0.0, 0.0, 0.0, None, 1, 1e9] if frame.kind == Kind.SETUP else []))

    monkeypatch.setattr(HostShare, "_take", lie)
    ran = runs(graph)
    assert ran.summary.outcome == Outcome.FAILED
    assert not any("was set" in line for line in ran.notices)
    assert any("sent what only this machine can measure" in line for line in ran.notices)


def test_ctrl_c_breaks_off_a_step_on_a_host(tmp_path: Path, hosted: Hosted) -> None:
    hangs = tmp_path / "hangs"
    graph = steps_graph(tmp_path, DEPLOY, first=f"{{at: 3, what: hang, file: {hangs}}}")
    graph.path.write_text(
        STEPS.format(deploy=DEPLOY, first=f"{{at: 3, what: hang, file: {hangs}}}", third="{}", more="")
    )
    hosted(graph)
    words = ["run", str(graph.path), "--plugin", str(STAGES), "-o", str(tmp_path / "run"), "--no-tap", "--no-pictures"]
    run = subprocess.Popen([sys.executable, "-m", "graphnav", *words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    wait_until(lambda: hangs.exists() and bool(hangs.read_text()))
    run.send_signal(signal.SIGINT)
    printed, _ = run.communicate(timeout=PATIENCE_S)
    assert run.returncode == 130, printed
    summary = json.loads((tmp_path / "run" / RunFolder.SUMMARY).read_text())
    assert summary["scores"]["second"] == {"steps": 2.0}, "its process was ended, and could not be asked"


def test_a_stage_on_a_host_is_not_changed(tmp_path: Path, runs: Runs, hosted: Hosted) -> None:
    graph = steps_graph(tmp_path, DEPLOY)
    hosted(graph)
    ran = runs(
        graph, changes={1.0: [request("second.takes_ms=1"), request("both=steps.both", "--set both.in.two=fast")]}
    )
    refused, _ = ran.answers
    assert [str(problem) for problem in refused.problems] == [
        (
            "stage 'second' (steps.add) stays as it is: it lives on the host jetson\n"
            "  change the graph on both, and start again"
        )
    ]
    assert ran.summary.outcome == "goal"


@pytest.mark.parametrize(
    ("deploy", "name", "said"),
    [
        (DEPLOY.replace("open", "third"), "jetson", "it has another graph, or runs it with other options"),
        (DEPLOY.replace("jetson", "xavier"), "xavier", "there is the host xavier"),
    ],
)
def test_who_has_another_graph_is_refused(
    tmp_path: Path, runs: Runs, hosted: Hosted, deploy: str, name: str, said: str
) -> None:
    hosted(steps_graph(tmp_path, deploy), name)
    ran = runs(steps_graph(tmp_path, DEPLOY))
    assert ran.summary.outcome == Outcome.FAILED
    assert f"it cannot live on the host jetson: {said}" in str(ran.summary.failure)


def test_who_has_another_key_is_refused(tmp_path: Path, runs: Runs, hosted: Hosted) -> None:
    graph = steps_graph(tmp_path, DEPLOY)
    made_key(tmp_path / KEY)
    share = hosted(graph, key="other.key")
    ran = runs(graph)
    assert ran.summary.outcome == Outcome.FAILED
    assert "refused the connection: another key" in str(ran.summary.failure)
    assert not share.told


def test_the_files_are_checked(tmp_path: Path, hosted: Hosted) -> None:
    graph = steps_graph(tmp_path, DEPLOY)
    with pytest.raises(UserError, match=r"hosts\.yaml is missing, beside the graph and here: it says where jetson is"):
        hosts_of(graph)
    hosted(graph)
    assert hosts_of(graph)["jetson"].address == "127.0.0.1"
    (tmp_path / FILE).write_text("hosts: {jetsen: {address: 127.0.0.1}}\n")
    with pytest.raises(
        UserError, match=r"the process '(eyes|mind)' lives on the host 'jetson', which .* does not name"
    ):
        hosts_of(graph)
    (tmp_path / FILE).write_text("hosts: {jetson: {port: 70000}}\n")
    with pytest.raises(UserError, match="does not say where it is"):
        hosts_of(graph)
    assert hosts_of(alone(graph)) == {}
    two = steps_graph(tmp_path, DEPLOY.replace("[open], host: jetson", "[open], host: orin"))
    (tmp_path / FILE).write_text("hosts:\n  jetson: {address: 10.0.0.5}\n  orin: {address: 10.0.0.5}\n")
    with pytest.raises(UserError, match=r"the hosts '(jetson|orin)' and '\w+' are both at 10\.0\.0\.5, port 7669"):
        hosts_of(two)


def test_a_host_without_processes_is_refused(tmp_path: Path) -> None:
    graph = steps_graph(tmp_path, DEPLOY)
    with pytest.raises(UserError, match=r"no process of steps lives on the host 'orin'\n.*its hosts are jetson"):
        serve_host(graph, "orin", None, tmp_path / "key", print, print)
