"""The process that sends the motor channels, suspended and killed: when that is told, and what the base hears."""

from __future__ import annotations

import os
import random
import re
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from statistics import median

from testbed.commands import CommandListener
from testbed.drives import GRAPHNAV
from testbed.rig import Rig, summary_of

from graphnav import Recording, Status
from graphnav.core.run_folder import RunFolder
from tests.targets import Targets

NUMBER = 216
MOVING_MPS = 0.05
PATIENCE_S = 20.0
SUSPENDED_S = 0.8, 3.0
MAX_TOLD_S = 0.2
"""A period of the guard, the 0.04 s for which a command may stay unread, and what a loaded machine adds."""
MAX_STOP_S = 0.6
"""``max_age_s``, a turn of the runner and what a loaded machine adds."""
BEGUN = "has not taken commands for"


class Suspensions:
    """A drive whose motor process is suspended again and again; durations in seconds."""

    def __init__(self, rig: Rig, commands: CommandListener) -> None:
        self._rig, self._commands = rig, commands
        self._run = rig.navigate(options=("--tap", "thin"))
        self.told_s: list[float] = []
        self.stop_s: list[float] = []
        self.back_s: list[float] = []
        self.first_stops = self.stale = self.in_top = 0

    @property
    def output(self) -> str:
        """The lines that the run has printed."""
        return (self._rig.folder / "navigation-0.txt").read_text()

    def motors(self) -> int:
        """Return the id of the motor process."""
        pids = Path(f"/proc/{self._run.pid}/task").glob("*/children")
        children = [int(pid) for file in pids for pid in file.read_text().split()]
        return next(
            pid for pid in children if b"graphnav.live.motors.child" in Path(f"/proc/{pid}/cmdline").read_bytes()
        )

    def suspend(self, rng: random.Random, *, look: bool) -> None:
        """Suspend it while the robot moves, for a random time; ``look``: also at what top says."""
        self.wait_for_motion(time.monotonic())
        pid, n_told, begin_s = self.motors(), self.output.count(BEGUN), time.monotonic()
        os.kill(pid, signal.SIGSTOP)
        wait(lambda: self.output.count(BEGUN) > n_told)
        self.told_s.append(time.monotonic() - begin_s)
        if look:
            top = subprocess.run([str(GRAPHNAV), "top", "--once"], capture_output=True, text=True, check=False).stdout
            self.in_top += bool(re.search(r"guard\.state +may [^\n]*, but not taken for [^\n]* sent", top))
        end_s = begin_s + rng.uniform(*SUSPENDED_S)
        wait(lambda: time.monotonic() >= end_s)
        stop = self._commands.first_stop(begin_s)
        self.stop_s.append(float("inf") if stop is None else stop.at_s - begin_s)
        resumed_s, resumed_us = time.monotonic(), time.time_ns() // 1000
        os.kill(pid, signal.SIGCONT)
        self.wait_for_motion(resumed_s)
        after = self._commands.since(resumed_s)
        self.first_stops += after[0].is_stop
        going = next(one for one in after if not one.is_stop)
        self.stale += going.utime < resumed_us
        self.back_s.append(going.at_s - resumed_s)

    def wait_for_motion(self, after_s: float) -> None:
        """Wait until the robot is told to move."""
        wait(lambda: any(one.v_mps > MOVING_MPS for one in self._commands.since(after_s)))

    def kill(self) -> int:
        """Kill the motor process; return how many stops came until the run had ended."""
        self.wait_for_motion(time.monotonic())
        begin_s = time.monotonic()
        os.kill(self.motors(), signal.SIGKILL)
        self._run.wait(PATIENCE_S)
        return sum(one.is_stop for one in self._commands.since(begin_s))


def wait(holds: Callable[[], bool]) -> None:
    """Wait until something holds; raise TimeoutError if it does not."""
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        if time.monotonic() > end_s:
            raise TimeoutError("what a suspension has to end in did not come")
        time.sleep(0.002)


def test_stopped_sender(targets: Targets, seeds: range, tmp_path: Path) -> None:
    """Suspend the motor process as many times as there are seeds, then kill it; print what was told and heard."""
    rng, n = random.Random(seeds[0]), len(seeds)
    with (
        Rig(tmp_path, NUMBER, seeds[0], ("--set", "robot.ends=false"), 15.0 * n + 60.0) as rig,
        CommandListener(rig.graph_url) as commands,
    ):
        drive = Suspensions(rig, commands)
        for k in range(n):
            drive.suspend(rng, look=k % 5 == 0)
        stops = drive.kill()
    summary = summary_of(tmp_path / "navigation-0")
    with Recording(tmp_path / "navigation-0" / RunFolder.LOG) as log:
        statuses = [one for _, _, one in log.messages("graphnav.status") if isinstance(one, Status)]
    recorded = sum(any(output["fault"] for output in one.outputs) for one in statuses)
    looked = len(range(0, n, 5))
    checks = {
        f"told in the terminal after {_spread(drive.told_s)} (limit {MAX_TOLD_S:g})": max(drive.told_s) <= MAX_TOLD_S,
        f"in top 'not taken' {drive.in_top} of {looked} times": drive.in_top == looked,
        f"in the log: {recorded} statuses with the fault": recorded >= n,
        f"first stop of the run itself after {_spread(drive.stop_s)} (limit {MAX_STOP_S:g})": (
            max(drive.stop_s) <= MAX_STOP_S
        ),
        f"resumed: {drive.first_stops} of {n} begin with a stop": drive.first_stops == n,
        f"commands from before the resumption: {drive.stale}": drive.stale == 0,
        f"the drive goes on after {_spread(drive.back_s)}": len(drive.back_s) == n,
        f"killed: outcome {summary['outcome']}, {stops} stops": summary["outcome"] == "failed" and stops >= 20,
    }
    for what, holds in checks.items():
        targets.check(what, good=holds)


def _spread(seconds: Sequence[float]) -> str:
    return f"{median(seconds):.3f} s, worst {max(seconds):.3f}"
