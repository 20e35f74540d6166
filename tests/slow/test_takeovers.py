"""A robot with two cameras on one channel: the second one does no harm, and takes over, through one stop, 20 times."""

from __future__ import annotations

import threading
import time
from itertools import groupby
from pathlib import Path
from types import TracebackType
from typing import Self

import lcm
from testbed.commands import CommandListener
from testbed.rig import Rig

from graphnav import GuardState, Recording
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

NUMBER = 219
TAKEOVERS = 20
BESIDE_S, SETTLES_S, PATIENCE_S = 1.5, 1.5, 20.0
FIRST_SEQS = 5_230, 17
MAX_DRIVE_S = 400.0
SLOW = ("--set", "control.max_speed_mps=0.12")
"""So that the drive lasts: a robot that stands at its goal against commands is frozen for the guard."""


class TwoCameras:
    """Two programs that publish the pictures of the robot's camera, each with numbers of its own, while they are on."""

    def __init__(self, robot_url: str, graph_url: str) -> None:
        self.is_on = [True, False]
        self._source = lcm.LCM(robot_url)
        self._targets = lcm.LCM(graph_url), lcm.LCM(graph_url)
        self._seqs = list(FIRST_SEQS)
        self._ending = threading.Event()
        self._source.subscribe("CAMERA", self._hear)
        self._thread = threading.Thread(target=self._carry)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ending.set()
        self._thread.join()

    def _hear(self, channel: str, data: bytes) -> None:
        for k, target in enumerate(self._targets):
            if self.is_on[k]:
                target.publish(channel, data[:16] + self._seqs[k].to_bytes(8, "big") + data[24:])
                self._seqs[k] += 1

    def _carry(self) -> None:
        while not self._ending.is_set():
            self._source.handle_timeout(50)


def test_takeovers(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Turn off the camera that is used, 20 times; print the stops and the times."""
    with (
        Rig(tmp_path, NUMBER, seeds[0], ("--set", "robot.ends=false"), MAX_DRIVE_S) as rig,
        CommandListener(rig.robot_url) as commands,
    ):
        rig.kill_camera()
        with TwoCameras(rig.robot_url, rig.graph_url) as cameras:
            rig.navigate(options=SLOW)
            _wait_to_drive(commands, time.monotonic(), 60.0)
            time.sleep(SETTLES_S)
            found = [_take_over(cameras, commands, k % 2) for k in range(TAKEOVERS)]
            rig.robot.terminate()
            _, summary = rig.finish()
    with Recording(tmp_path / "navigation-0" / RunFolder.LOG) as log:
        states = [m for _, _, m in log.messages("guard.state") if isinstance(m, GuardState)]
    faults = sum(is_fault for is_fault, _ in groupby("fault" in state.causes for state in states))
    (camera,) = (one for one in summary["live"]["inputs"] if one["channel"] == "CAMERA")
    rejected = dict(zip(camera["reasons"], camera["rejected"], strict=True))
    beside, stops, driving_s = zip(*found, strict=True)
    is_right = set(beside) == {0} and set(stops) == {1} and faults == TAKEOVERS and summary["outcome"] == "stopped"
    targets.check(
        f"{len(found)} takeovers: stops beside a second camera {sum(beside)}, in each takeover {min(stops)} to "
        f"{max(stops)}, faults {faults}; the robot drives on {min(driving_s):.2f} to {max(driving_s):.2f} s after the "
        f"last picture; rejected {rejected}",
        good=is_right,
    )


def _take_over(cameras: TwoCameras, commands: CommandListener, used: int) -> tuple[int, int, float]:
    """Turn on the other camera, then off the used one; return the stops of both, and the time until it drives."""
    begin_s = time.monotonic()
    cameras.is_on[1 - used] = True
    time.sleep(BESIDE_S)
    off_s = time.monotonic()
    beside = _stops(commands, begin_s, off_s)
    cameras.is_on[used] = False
    time.sleep(0.3)
    while not commands.first_stop(off_s) and time.monotonic() < off_s + PATIENCE_S:
        time.sleep(0.02)
    stop = commands.first_stop(off_s)
    driving_s = _wait_to_drive(commands, time.monotonic() if stop is None else stop.at_s, PATIENCE_S)
    time.sleep(SETTLES_S)
    return beside, _stops(commands, off_s, time.monotonic()), driving_s - off_s


def _stops(commands: CommandListener, begin_s: float, end_s: float) -> int:
    """Return the number of times that the robot was stopped between two times."""
    heard = [one.is_stop for one in commands.since(begin_s) if one.at_s < end_s]
    return sum(is_stop for is_stop, _ in groupby(heard))


def _wait_to_drive(commands: CommandListener, after_s: float, within_s: float) -> float:
    """Return when the robot was told to drive after a time; raise TimeoutError if it is not."""
    end_s = time.monotonic() + within_s
    while time.monotonic() < end_s:
        driving = next((one for one in commands.since(after_s) if not one.is_stop), None)
        if driving is not None:
            return driving.at_s
        time.sleep(0.02)
    raise TimeoutError(f"the robot does not drive within {within_s:g} s")
