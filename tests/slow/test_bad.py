"""Bad messages on every channel that a driving graph listens on: what is counted, and that none is acted upon.

Messages are spoiled on their way (every second one of a channel), or sent by a second program on the same channel. The
graph's log holds every message that was handed to a stage: each has to be one that the true sender sent, once. A stop
is the exception: it counts from any sender.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
import time
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import graphnav_lcm
import lcm
import pytest
from testbed.commands import CommandListener
from testbed.corrupt import CLASSES, KINDS
from testbed.drives import GRAPHNAV
from testbed.rig import Rig

from graphnav import Recording, Status
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

from .bad_sender import GARBAGE, SECOND_WRITER, WELL_FORMED

INPUTS = {"CAMERA": "camera.image", "ODOMETRY": "base.odometry", "TELEOP": "operator.twist", "STOP": "operator.stop"}
SENT = (SECOND_WRITER, GARBAGE, WELL_FORMED)
FIRST_NUMBER = 231
SPOILED_S = 1.5
FLOOD_S = 5.0
SETTLES_S = 2.2
RECOVERS_S = 15.0
OPERATOR_MPS = 0.05
Counts = Mapping[str, int]


@dataclass
class Phase:
    """One kind of bad messages; times are microseconds of the wall clock."""

    kind: str
    begin_us: int
    end_us: int = 0
    n_sent: str = ""
    drove_on: bool = False


@dataclass
class Heard:
    """The effect of the bad messages of one channel."""

    channel: str
    phases: list[Phase]
    top: dict[str, Any]
    summary: dict[str, Any]
    status: list[tuple[int, Counts]]
    foreign: int
    delivered: int
    outcome: str
    robot: str


class TrueSenders:
    """Keeps what the robot's own programs send, and, where asked, sends as an operator would."""

    def __init__(self, url: str, operated: str) -> None:
        self.sent: dict[str, Counter[bytes]] = {channel: Counter() for channel in CLASSES}
        self._lcm, self._out = lcm.LCM(url), lcm.LCM(url)
        self._operated = operated
        self._ending = threading.Event()
        for channel in CLASSES:
            self._lcm.subscribe(channel, self._hear).set_queue_capacity(0)
        self._threads = [threading.Thread(target=self._listen), threading.Thread(target=self._operate)]

    def __enter__(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ending.set()
        for thread in self._threads:
            thread.join()

    def _hear(self, channel: str, data: bytes) -> None:
        self.sent[channel][data] += 1

    def _listen(self) -> None:
        while not self._ending.is_set():
            self._lcm.handle_timeout(100)

    def _operate(self) -> None:
        seq = 0
        while self._operated in ("TELEOP", "STOP") and not self._ending.wait(0.1):
            message = CLASSES[self._operated]()
            message.utime, message.seq = time.time_ns() // 1000, seq
            if isinstance(message, graphnav_lcm.twist_t):
                message.v_mps = OPERATOR_MPS
            self._out.publish(self._operated, message.encode())
            seq += 1


@pytest.mark.parametrize("channel", CLASSES)
def test_bad(targets: Targets, seeds: range, tmp_path: Path, channel: str) -> None:
    """Send every kind of bad message on a channel during a drive; print what was counted."""
    _judge(targets, _drive(channel, seeds[0], tmp_path))


def _drive(channel: str, seed: int, folder: Path) -> Heard:
    number = FIRST_NUMBER + list(CLASSES).index(channel)
    with (
        Rig(folder, number, seed, ("--set", "robot.ends=false")) as rig,
        CommandListener(rig.robot_url) as commands,
        TrueSenders(rig.robot_url, channel) as true,
    ):
        navigation = rig.folder / "navigation-0"
        _navigate(rig, navigation)
        _wait_to_drive(commands, time.monotonic(), 60.0)
        time.sleep(SETTLES_S)
        phases = [_meet(rig, commands, channel, kind) for kind in (*KINDS[channel], *SENT)]
        top = _top(rig, rig.folder / "navigation-0.txt")
        rig.robot.terminate()
        robot, summary = rig.finish()
        status, delivered = _read_log(navigation, INPUTS[channel])
    foreign = sum((delivered - true.sent[channel]).values())
    if channel == "STOP":
        foreign = sum(1 for data in delivered if data not in true.sent[channel] and not _engages(data))
    return Heard(
        channel, phases, top, summary, status, foreign, delivered.total(), summary["outcome"], robot["outcome"]
    )


def _navigate(rig: Rig, run: Path) -> None:
    words = ["run", "navigate_live", "--url", rig.graph_url, "--no-pictures", "--json", "--set", "run.record=all"]
    with run.with_suffix(".txt").open("wb") as output:
        process = subprocess.Popen([str(GRAPHNAV), *words, "-o", str(run)], stdout=output, stderr=subprocess.STDOUT)
    rig.navigation.append(process)


def _meet(rig: Rig, commands: CommandListener, channel: str, kind: str) -> Phase:
    phase = Phase(kind, time.time_ns() // 1000)
    if kind in SENT:
        for_s = SPOILED_S if kind == SECOND_WRITER else FLOOD_S
        sender = [sys.executable, "-m", "tests.slow.bad_sender", rig.graph_url, channel, kind, str(for_s)]
        env = os.environ | {"PYTHONPATH": "tools"}  # where the sender's own imports are found
        phase.n_sent = subprocess.run(sender, check=True, capture_output=True, text=True, env=env).stdout.strip()
    else:
        rig.corrupt(channel, kind)
        time.sleep(SPOILED_S)
        rig.corrupt(channel, "")
    end_s = time.monotonic()
    time.sleep(SETTLES_S)
    phase.end_us = time.time_ns() // 1000
    phase.drove_on = _wait_to_drive(commands, end_s, RECOVERS_S)
    return phase


def _wait_to_drive(commands: CommandListener, after_s: float, within_s: float) -> bool:
    end_s = time.monotonic() + within_s
    while not any(one.v_mps > 0 for one in commands.since(after_s)):
        if time.monotonic() > end_s:
            return False
        time.sleep(0.05)
    return True


def _top(rig: Rig, output: Path) -> dict[str, Any]:
    """Return what ``graphnav top`` says of the navigation's inputs."""
    found = re.search(r"run (\w+) on ", output.read_text())
    done = subprocess.run([str(GRAPHNAV), "top", "--once", "--json"], capture_output=True, text=True, check=False)
    assert found is not None, output.read_text()
    for run in json.loads(done.stdout)["runs"] if done.stdout else ():
        if run["run_id"] == found[1]:
            return {one["name"]: one for one in run["status"]["inputs"]}
    raise RuntimeError(f"graphnav top does not show {rig.folder}: {done.stderr}")


def _read_log(run: Path, ref: str) -> tuple[list[tuple[int, Counts]], Counter[bytes]]:
    """Return what each status counted, by stamp, and the bytes of the messages that were handed to stages."""
    statuses: list[tuple[int, Counts]] = []
    delivered: Counter[bytes] = Counter()
    with Recording(run / RunFolder.LOG) as log:
        for event in log.events():
            if event.channel == ref:
                delivered[event.data] += 1
        for utime, _, status in log.messages("graphnav.status"):
            assert isinstance(status, Status)
            statuses += [(utime, _rejected(one)) for one in status.inputs if one["name"] == ref]
    return statuses, delivered


def _rejected(one: Mapping[str, Any]) -> Counts:
    return dict(zip(one["reasons"], (int(n) for n in one["rejected"]), strict=True))


def _engages(data: bytes) -> bool:
    return bool(graphnav_lcm.stop_t.decode(data).engaged)


def _judge(targets: Targets, heard: Heard) -> None:
    ref = INPUTS[heard.channel]
    for phase in heard.phases:
        before = next((c for utime, c in reversed(heard.status) if utime <= phase.begin_us), {})
        after = next((c for utime, c in reversed(heard.status) if utime <= phase.end_us), {})
        counted = {reason: n - before.get(reason, 0) for reason, n in after.items() if n > before.get(reason, 0)}
        is_met = bool(counted or (heard.channel == "STOP" and phase.kind in (SECOND_WRITER, WELL_FORMED)))
        sent = f" ({phase.n_sent} sent)" if phase.n_sent else ""
        drove = "drives on" if phase.drove_on else "does not drive on"
        text = f"{heard.channel}, {phase.kind}{sent}: counted {counted}; {drove}"
        targets.check(text, good=is_met and phase.drove_on)
    summed = _rejected(next(one for one in heard.summary["live"]["inputs"] if one["name"] == ref))
    rejected = heard.top[ref]["rejected"]
    agree = all(rejected.get(reason, 0) <= n for reason, n in summed.items()) and set(rejected) == set(summed)
    targets.check(
        f"{heard.channel}: of {heard.delivered} messages that stages got {heard.foreign} were not the sender's; top "
        f"and summary {'agree' if agree else 'differ'}: {summed}; the run ended: {heard.outcome}, the robot's: "
        f"{heard.robot}",
        good=agree and heard.foreign == 0 and heard.outcome == heard.robot == "stopped",
    )
