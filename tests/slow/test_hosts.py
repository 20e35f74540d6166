"""Two computers, in network namespaces joined by a cable: the same log, live drives, cut cables, kills, refusals."""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import signal
import subprocess
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from testbed.drives import GRAPHNAV
from testbed.processes import running

from graphnav import Recording, Status
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

from .harms import STANDS_MPS, Harm, harm_of, states_of

PATIENCE_S = 120.0
SSHD = "/usr/sbin/sshd"
N_REFUSALS = 10
OTHER_VERSION = """
import importlib.metadata as metadata
found = metadata.version
metadata.version = lambda name: "0.1.0" if name == "graphnav" else found(name)
"""
POLICY = "host: jetson, restart: on_failure, restart_delay_s: 0.1, max_restarts: 100"
STOP_S = 1.0
"""Time until the robot brakes: as in several processes of one computer, and the network."""
QUIET = "--no-tap", "--no-pictures"
ROBOT = "run", "robot_live", *QUIET, "--set", "robot.state_hz=100", "--until", "200"
CLOCK_STEPS_S = 5 * (0.3, 3600.0, -0.3, -3600.0)
STEP_ERROR_S = 0.1
"""Half of a round trip to a computer that is busy."""
_STEP = re.compile(r"the clock of the host jetson was set ([\d.]+) s (back|ahead)")
HARMS = ("cable out for 0.2 s", "cable out for 1 s", "cable out for 10 s", "stages killed", "computer's command killed")


def ip(*words: str) -> None:
    """Run ip."""
    subprocess.run(["ip", *words], check=True, capture_output=True)


class Computers:
    """The robot's computer, 10.98.0.1, and another one, 10.98.0.2, with one folder for both."""

    def __init__(self, folder: Path, cleanup: ExitStack) -> None:
        self.folder, self._cleanup = folder, cleanup
        self.environments: tuple[list[str], list[str]] = [], []
        """Variables of what is started on each."""
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
        """Start a command of graphnav on one of them, which prints into a file of its name."""
        return self.execute(computer, name, str(GRAPHNAV), *words)

    def execute(self, computer: int, name: str, *words: str) -> subprocess.Popen[bytes]:
        """Start a program on one of them, as `start` does."""
        command = ["env", "-C", str(self.folder), f"HOME={self.folder}", f"XDG_STATE_HOME={self.folder}/state"]
        command += [*self.environments[computer], "ip", "netns", "exec", self._names[computer], *words]
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

    def serve_ssh(self) -> None:
        """Let OpenSSH's server on the other computer let in who runs this, and the robot's computer know it."""
        ssh = self.folder / ".ssh"
        ssh.mkdir(mode=0o700)
        for name in ("host", "id_ed25519"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(ssh / name)], check=True)
        (ssh / "known_hosts").write_text(f"10.98.0.2 {(ssh / 'host.pub').read_text()}")
        options = {"HostKey": ssh / "host", "AuthorizedKeysFile": ssh / "id_ed25519.pub", "PidFile": "none"}
        options |= {"StrictModes": "no", "PermitRootLogin": "yes", "UsePAM": "no"}
        Path("/run/sshd").mkdir(exist_ok=True)
        self.execute(1, "sshd", SSHD, "-D", "-e", "-f", "/dev/null", *(f"-o{key}={v}" for key, v in options.items()))
        self.await_text("sshd", "Server listening")
        here = {"address": "10.98.0.2", "user": "root", "command": str(GRAPHNAV), "folder": str(self.folder)}
        (self.folder / "hosts.yaml").write_text(json.dumps({"hosts": {"jetson": here}}))

    def left_on_the_other(self, *words: str) -> list[int]:
        """Return the processes on the other computer that were started with some words."""
        found = subprocess.run(["ip", "netns", "pids", self._names[1]], capture_output=True, text=True, check=True)
        return [pid for pid in map(int, found.stdout.split()) if set(words) <= set(_words(pid))]

    def summary(self, run: str) -> dict[str, Any]:
        """Return the summary of a run that has ended."""
        return dict(json.loads((self.folder / run / RunFolder.SUMMARY).read_text()))

    def outcome(self, run: str) -> str:
        """Return the outcome of a run."""
        return str(self.summary(run)["outcome"])

    def p50_ms(self, run: str) -> float:
        """Return the median time from an image to the command that follows from it."""
        return float(self.summary(run)["live"]["outputs"][0]["latency_p50_ms"])


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
    file, options = computers.write("two.yaml", graph, stages), ("--until", "5", *QUIET)
    computers.start(1, "jetson", "run", file, "--host", "jetson")
    computers.await_text("jetson", "waits on port")
    walls_s = {}
    for name, words in {"one": (graph,), "two": (file,)}.items():
        assert computers.start(0, name, "run", *words, *options, "-o", name).wait(PATIENCE_S) == 0
        walls_s[name] = computers.summary(name)["wall_s"]
    logs = [(computers.folder / name / "run.lcmlog").read_bytes() for name in walls_s]
    text = f"{graph}: one computer {walls_s['one']:.1f} s, two {walls_s['two']:.1f} s, {len(logs[0])} bytes"
    targets.check(text, good=logs[0] == logs[1])


def test_live_drives_with_cables_out_and_kills(computers: Computers, targets: Targets, seeds: range) -> None:
    """How a robot brakes and drives on, each time; latency and arrivals beside those of one computer."""
    file, found, outcomes = computers.write("eyes.yaml", "navigate_live", "flow, plane"), defaultdict(list), []
    jetson = computers.start(1, "jetson", "run", file, "--host", "jetson")
    computers.await_text("jetson", "waits on port")
    for seed in seeds:
        robot = computers.start(0, f"robot{seed}", *ROBOT, "--seed", str(seed), "-o", f"robot{seed}")
        run = computers.start(0, f"run{seed}", "run", file, *QUIET, "-o", f"run{seed}")
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
                jetson = computers.start(1, "jetson", "run", file, "--host", "jetson")
            if kind not in HARMS[:2]:
                computers.await_text(f"run{seed}", "is back after", n_back + 1)
            time.sleep(4.0)
        robot.wait(PATIENCE_S + 100)
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE_S)
        states = states_of(computers.folder / f"robot{seed}")
        outcomes.append(computers.outcome(f"robot{seed}"))
        has_contact = any(state.contact for _, state in states)
        for (kind, begin_s), end_s in zip(begun.items(), [*list(begun.values())[1:], math.inf], strict=True):
            found[kind].append(harm_of(kind, begin_s, [one for one in states if one[0] < end_s], 10.0))
        targets.check(f"seed {seed}: {outcomes[-1]}, p50 {computers.p50_ms(f'run{seed}'):.1f} ms", good=not has_contact)
    for kind, harms in found.items():
        targets.check(_told(kind, harms), good=kind == HARMS[0] or max(one.brakes_s for one in harms) <= STOP_S)


def test_the_robot_is_on_the_other_computer(computers: Computers, targets: Targets, seeds: range) -> None:
    """Camera and base on one, the graph on the other, joined by a tunnel; beside it both on one."""
    computers.start(1, "serve", "tunnel", "--serve", "--in", "BASE_CMD")
    computers.await_text("serve", "serving")
    computers.start(0, "tunnel", "tunnel", "10.98.0.2", "--out", "BASE_CMD")
    computers.await_text("tunnel", "joining")
    for seed in seeds:
        found = {}
        for place, name in enumerate(("one", "two")):
            robot, run = f"robot-{name}-{seed}", f"run-{name}-{seed}"
            started = computers.start(place, robot, *ROBOT, "--seed", str(seed), "-o", robot)
            graph = computers.start(0, run, "run", "navigate_robot", *QUIET, "-o", run)
            started.wait(PATIENCE_S + 100)
            graph.send_signal(signal.SIGINT)
            graph.wait(PATIENCE_S)
            found[name] = computers.outcome(robot), computers.p50_ms(run)
        told = ", ".join(
            f"{name} computer{'s' * (name == 'two')}: {one[0]}, p50 {one[1]:.1f} ms" for name, one in found.items()
        )
        targets.check(f"seed {seed}: {told}", good=found["two"][0] == "goal")


def test_up_drives_live(computers: Computers, targets: Targets, seeds: range) -> None:
    """Over OpenSSH: arrivals, and what is left on the other computer after Ctrl-C."""
    if not Path(SSHD).exists():
        pytest.skip(f"{SSHD} is missing")
    computers.serve_ssh()
    file = computers.write("eyes.yaml", "navigate_live", "flow, plane")
    for seed in seeds:
        robot, run = f"robot{seed}", f"run{seed}"
        started = computers.start(0, robot, *ROBOT, "--seed", str(seed), "-o", robot)
        up = computers.start(0, run, "up", file, *QUIET, "-o", run)
        started.wait(PATIENCE_S + 100)
        up.send_signal(signal.SIGINT)
        asked_s = time.monotonic()
        status = up.wait(PATIENCE_S)
        while left := computers.left_on_the_other("--host", "jetson"):
            assert time.monotonic() < asked_s + PATIENCE_S, left
            time.sleep(0.02)
        seen = f"p50 {computers.p50_ms(run):.1f} ms, nothing left after {time.monotonic() - asked_s:.2f} s"
        targets.check(
            f"seed {seed}: {computers.outcome(robot)}, {seen}",
            good=status == 130 and computers.outcome(robot) == "goal",
        )


def test_who_is_refused(computers: Computers, targets: Targets) -> None:
    """Another graph, other values, another version, another key: each so many times, and the line that tells it."""
    file = computers.write("two.yaml", "corridor_ccw", "flow, planar, plane")
    jetson = ("run", file, "--host", "jetson")
    other = computers.write("other.yaml", "corridor_ccw", "flow, plane")
    (computers.folder / "old").mkdir()
    (computers.folder / "old" / "sitecustomize.py").write_text(OTHER_VERSION)
    cases = {
        "another graph": ((str(GRAPHNAV), "run", other, "--host", "jetson"), "it has another graph"),
        "other values": (
            (str(GRAPHNAV), *jetson, "--set", "flow.window_radius_px=9"),
            "it has another graph, or runs it with",
        ),
        "another version": (
            ("env", f"PYTHONPATH={computers.folder}/old", str(GRAPHNAV), *jetson),
            "another graphnav: ",
        ),
        "another key": ((str(GRAPHNAV), *jetson, "--key", "other.key"), "another key"),
    }
    for what, (words, said) in cases.items():
        statuses, n_said, lines = Counter[int](), 0, list[str]()
        share = computers.execute(1, what, *words)
        computers.await_text(what, "waits on port")
        for number in range(N_REFUSALS):
            name = f"{what} {number}"
            run = computers.start(0, name, "run", file, "--until", "5", *QUIET, "-o", name)
            statuses[run.wait(PATIENCE_S)] += 1
            lines = [line for line in (computers.folder / f"{name}.txt").read_text().splitlines() if said in line]
            n_said += bool(lines)
        share.send_signal(signal.SIGINT)
        share.wait(PATIENCE_S)
        text = f"{what}: {n_said} of {N_REFUSALS} told, exit statuses {dict(statuses)}"
        targets.check(text, good=n_said == N_REFUSALS and set(statuses) == {1})
        targets.say(lines[0] if lines else "nothing was told")


def test_clocks_that_are_set(computers: Computers, targets: Targets, seeds: range) -> None:
    """The clock of the computer with the stages is set again and again while the robot drives: it never stops for it.

    Only the time of day there is another one, as where it is set: libfaketime adds what a file says.
    """
    library = next(Path("/usr/lib").glob("*/faketime/libfaketimeMT.so.1"), None)
    if library is None:
        pytest.skip("a clock is set by libfaketime: apt-get install faketime")
    clock = computers.folder / "clock"
    computers.environments[1][:] = [
        f"LD_PRELOAD={library}", f"FAKETIME_TIMESTAMP_FILE={clock}", "FAKETIME_NO_CACHE=1",
        "FAKETIME_DONT_FAKE_MONOTONIC=1", "NO_FAKE_STAT=1",
    ]  # fmt: skip
    _set_clock(clock, 0.0)
    file, ahead_s, steps_s = computers.write("eyes.yaml", "navigate_live", "flow, plane"), 0.0, list(CLOCK_STEPS_S)
    computers.start(1, "jetson", "run", file, "--host", "jetson")
    computers.await_text("jetson", "waits on port")
    n_told, stands, outcomes, offsets_s = 0, 0, list[str](), list[float]()
    for seed in seeds:
        if not steps_s:
            break
        robot = computers.start(0, f"robot{seed}", *ROBOT, "--seed", str(seed), "-o", f"robot{seed}")
        run = computers.start(0, f"run{seed}", "run", file, *QUIET, "-o", f"run{seed}")
        computers.await_text("jetson", "process 'eyes' for the run at", len(outcomes) + 1)
        time.sleep(5.0)
        begin_s, n_set = time.time(), 0
        while steps_s and robot.poll() is None:
            ahead_s += (step_s := steps_s.pop(0))
            n_set += 1
            _set_clock(clock, ahead_s)
            n_told += _is_told(computers.folder / f"run{seed}.txt", n_set, step_s)
        end_s = time.time()
        time.sleep(3.0)
        robot.send_signal(signal.SIGINT)
        robot.wait(PATIENCE_S)
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE_S)
        states = [one for one in states_of(computers.folder / f"robot{seed}") if begin_s <= one[0] <= end_s + 2.0]
        stands += sum(
            abs(state.v_mps) < STANDS_MPS <= abs(before.v_mps) and not state.at_goal
            for (_, before), (_, state) in pairwise(states)
        )
        with Recording(computers.folder / f"run{seed}" / RunFolder.LOG) as log:
            status = [status for _, _, status in log.messages(Status.CHANNEL) if isinstance(status, Status)][-1]
        offsets_s += [one["clock_offset_s"] - ahead_s for one in status.processes if one["host"]]
        outcomes.append(f"{len(states) / 100:.0f} s")
    n_steps = len(CLOCK_STEPS_S) - len(steps_s)
    text = f"clock set {n_steps} times in {', '.join(outcomes)} of driving: {n_told} told, {stands} stops of the robot"
    targets.check(text, good=n_steps == n_told == len(CLOCK_STEPS_S) and not stands)
    targets.check(f"wrong by {1e3 * max(map(abs, offsets_s)):.2f} ms at the end", good=max(map(abs, offsets_s)) < 0.05)


def _set_clock(file: Path, ahead_s: float) -> None:
    """Set the clock that a file tells, which is never incomplete."""
    aside = file.with_suffix(".new")
    aside.write_text(f"{ahead_s:+.1f}")
    aside.rename(file)


def _is_told(printed: Path, times: int, step_s: float) -> bool:
    """Wait until a run has told so many steps; return whether the last one is as expected."""
    end_s = time.monotonic() + PATIENCE_S
    while len(told := _STEP.findall(printed.read_text())) < times:
        if time.monotonic() > end_s:
            return False
        time.sleep(0.05)
    size, way = told[-1]
    return len(told) == times and abs((-1 if way == "back" else 1) * float(size) - step_s) < STEP_ERROR_S


def _told(kind: str, harms: list[Harm]) -> str:
    brakes, on = (", ".join(f"{value:.2f}" for value in column) for column in zip(*(h[1:] for h in harms), strict=True))
    return f"{kind}: {len(harms)} times; brakes after {brakes} s; drives on after {on} s"


def _words(pid: int) -> list[str]:
    with suppress(OSError):  # it has ended
        return Path(f"/proc/{pid}/cmdline").read_text().split("\0")
    return []


def _children(pid: int) -> list[int]:
    return [int(one) for one in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
