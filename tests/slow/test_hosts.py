"""One graph on two computers, in network namespaces joined by a cable: the same log, live drives, cut cables, kills."""

from __future__ import annotations

import json
import math
import os
import shutil
import signal
import subprocess
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import running

from tests.targets import Targets

from .harms import Harm, harm_of, states_of

PATIENCE_S = 120.0
POLICY = "host: jetson, restart: on_failure, restart_delay_s: 0.1, max_restarts: 100"
STOP_S = 1.0
"""Time until the robot brakes: as in several processes of one computer, and the network."""
HARMS = ("cable out for 0.2 s", "cable out for 1 s", "cable out for 10 s", "stages killed", "computer's command killed")


def ip(*words: str) -> None:
    """Run ip."""
    subprocess.run(["ip", *words], check=True, capture_output=True)


class Computers:
    """The robot's computer, 10.98.0.1, and another one, 10.98.0.2, with one folder for both."""

    def __init__(self, folder: Path, cleanup: ExitStack) -> None:
        self.folder, self._cleanup = folder, cleanup
        number = os.getpid()
        self._names = f"gn-a-{number}", f"gn-b-{number}"
        self._cables = f"gna{number}", f"gnb{number}"
        for name in self._names:
            ip("netns", "add", name)
            cleanup.callback(ip, "netns", "del", name)
        ip("link", "add", self._cables[0], "type", "veth", "peer", "name", self._cables[1])
        for k, (name, cable) in enumerate(zip(self._names, self._cables, strict=True), 1):
            ip("link", "set", cable, "netns", name)
            ip("-n", name, "addr", "add", f"10.98.0.{k}/24", "dev", cable)
            ip("-n", name, "link", "set", cable, "up")
            ip("-n", name, "link", "set", "lo", "up", "multicast", "on")
            ip("-n", name, "route", "add", "224.0.0.0/4", "dev", "lo")
        (folder / "hosts.yaml").write_text("hosts: {jetson: {address: 10.98.0.2}}\n")

    def write(self, name: str, graph: str, stages: str) -> str:
        """Write a graph with some stages on the other computer; return its file's name."""
        (self.folder / name).write_text(f"extends: {graph}\ndeploy: {{eyes: {{stages: [{stages}], {POLICY}}}}}\n")
        return name

    def start(self, computer: int, name: str, *words: str) -> subprocess.Popen[bytes]:
        """Start a run on one of them, which prints into a file of its name."""
        command = ["env", "-C", str(self.folder), f"XDG_STATE_HOME={self.folder}/state", "ip", "netns", "exec"]
        command += [self._names[computer], str(GRAPHNAV), "run", *words]
        return self._cleanup.enter_context(running(command, self.folder / f"{name}.txt"))

    def plug(self, *, is_in: bool) -> None:
        """Pull the cable, or put it in again."""
        ip("-n", self._names[0], "link", "set", self._cables[0], "up" if is_in else "down")

    def await_text(self, name: str, text: str, times: int = 1) -> None:
        """Wait until a command has printed something so many times."""
        end_s = time.monotonic() + PATIENCE_S
        while (printed := (self.folder / f"{name}.txt").read_text()).count(text) < times:
            assert time.monotonic() < end_s, printed
            time.sleep(0.05)


@pytest.fixture
def computers(tmp_path: Path) -> Iterator[Computers]:
    """Return two computers."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        pytest.skip("network namespaces need root and ip")
    with ExitStack() as cleanup:
        yield Computers(tmp_path, cleanup)


@pytest.mark.parametrize("graph", ["corridor_ccw", "navigate"])
def test_the_log_in_lockstep_is_that_of_one_process(computers: Computers, targets: Targets, graph: str) -> None:
    stages = "flow, plane" if graph == "navigate" else "flow, planar, plane"
    file, options = computers.write("two.yaml", graph, stages), ("--until", "5", "--no-tap", "--no-pictures")
    computers.start(1, "jetson", file, "--host", "jetson")
    computers.await_text("jetson", "waits on port")
    walls_s = {}
    for name, words in {"one": (graph,), "two": (file,)}.items():
        assert computers.start(0, name, *words, *options, "-o", name).wait(PATIENCE_S) == 0
        walls_s[name] = json.loads((computers.folder / name / "summary.json").read_text())["wall_s"]
    logs = [(computers.folder / name / "run.lcmlog").read_bytes() for name in walls_s]
    text = f"{graph}: one computer {walls_s['one']:.1f} s, two {walls_s['two']:.1f} s, {len(logs[0])} bytes"
    targets.check(text, good=logs[0] == logs[1])


def test_live_drives_with_cables_out_and_kills(computers: Computers, targets: Targets, seeds: range) -> None:
    """How a robot brakes and drives on, each time; latency and arrivals beside those of one computer."""
    file, found, outcomes = computers.write("eyes.yaml", "navigate_live", "flow, plane"), defaultdict(list), []
    jetson = computers.start(1, "jetson", file, "--host", "jetson")
    computers.await_text("jetson", "waits on port")
    for seed in seeds:
        robot = computers.start(0, f"robot{seed}", "robot_live", "--seed", str(seed), "--set", "robot.state_hz=100",
                                "--until", "200", "--no-tap", "--no-pictures", "-o", f"robot{seed}")  # fmt: skip
        run = computers.start(0, f"run{seed}", file, "--no-tap", "--no-pictures", "-o", f"run{seed}")
        time.sleep(5.0)
        begun = dict[str, float]()
        for kind in HARMS:
            if robot.poll() is not None:
                break
            n_back = (computers.folder / f"run{seed}.txt").read_text().count("is back after")
            begun[kind] = time.time()
            if kind.startswith("cable"):
                computers.plug(is_in=False)
                time.sleep(float(kind.split()[-2]))
                computers.plug(is_in=True)
            elif kind == "stages killed":
                os.kill(_children(jetson.pid)[-1], signal.SIGKILL)
            else:
                jetson.kill()
                jetson = computers.start(1, "jetson", file, "--host", "jetson")
            if kind not in HARMS[:2]:
                computers.await_text(f"run{seed}", "is back after", n_back + 1)
            time.sleep(4.0)
        robot.wait(PATIENCE_S + 100)
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE_S)
        states = states_of(computers.folder / f"robot{seed}")
        outcomes.append(json.loads((computers.folder / f"robot{seed}" / "summary.json").read_text())["outcome"])
        has_contact = any(state.contact for _, state in states)
        for (kind, begin_s), end_s in zip(begun.items(), [*list(begun.values())[1:], math.inf], strict=True):
            found[kind].append(harm_of(kind, begin_s, [one for one in states if one[0] < end_s], 10.0))
        latency = json.loads((computers.folder / f"run{seed}" / "summary.json").read_text())["live"]["outputs"][0]
        targets.check(f"seed {seed}: {outcomes[-1]}, p50 {latency['latency_p50_ms']:.1f} ms", good=not has_contact)
    for kind, harms in found.items():
        targets.check(_told(kind, harms), good=kind == HARMS[0] or max(one.brakes_s for one in harms) <= STOP_S)


def _told(kind: str, harms: list[Harm]) -> str:
    brakes, on = (", ".join(f"{value:.2f}" for value in column) for column in zip(*(h[1:] for h in harms), strict=True))
    return f"{kind}: {len(harms)} times; brakes after {brakes} s; drives on after {on} s"


def _children(pid: int) -> list[int]:
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
