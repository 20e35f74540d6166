"""Faults at random moments of live drives: when the robot is told to stop, when it stands, whether it drives on.

The stop is heard on the robot's motor channel by a plain LCM program: the first one after which nothing else is sent
before the fault ends. When the robot stands, and contacts, are read from the world's own log. A fault of the camera is
counted from when the relay is told, one of a stage from when the stage begins to misbehave, a signal from when it is
sent. The age of a frame counts from its own arrival, so a silent camera stops the robot up to a frame's period earlier
than the limit.
"""

from __future__ import annotations

import random
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from testbed.commands import CommandListener
from testbed.rig import Rig, navigation_words

from tests.targets import Targets

from .launched import Launched, Launcher
from .safety_faults import ENDING, PASSING, Fault
from .safety_metrics import Measured, States, lines

GRAPH = str(Path(__file__).with_name("navigate_faulty.yaml"))
ROBOT = ("--set", "robot.state_hz=100")
FIRST_NUMBER = 221
MAX_DRIVE_S = 600.0
MOVING_MPS = 0.05
MOVING_S = 0.8
FAULT_S = 1.5
RECOVERS_S = 15.0
ENDS_S = 5.0
STANDS_S = 0.5
MAX_TRIES = 3


@dataclass
class Event:
    """The effect of one fault; all times are monotonic seconds."""

    fault: Fault
    begin_s: float
    stop_s: float | None = None
    end_s: float = 0.0
    resumed_s: float | None = None


class RobotGoneError(Exception):
    """The robot's run has ended."""


class FaultyDrive:
    """One drive with one fault after the other."""

    def __init__(self, rig: Rig, launcher: Launcher, commands: CommandListener, rng: random.Random) -> None:
        self.rig = rig
        self.navigation: Launched
        self.fault_file = rig.folder / "fault"
        self._launcher, self._commands, self._rng = launcher, commands, rng
        self._count = 0

    def restart(self) -> None:
        """Start the navigation graph, again where one ran."""
        self._count += 1
        run = self.rig.folder / f"navigation-{self._count}"
        words = navigation_words(GRAPH, self.rig.graph_url, run)
        self.navigation = self._launcher.start(words, run.with_suffix(".txt"), {"FAULT_FILE": str(self.fault_file)})

    def wait_for(self, holds: Callable[[], object], within_s: float) -> bool:
        """Return whether something came to hold; raise RobotGoneError where the robot's run ends before."""
        end_s = time.monotonic() + within_s
        while not holds():
            if not self.rig.is_driving:
                raise RobotGoneError
            if time.monotonic() > end_s:
                return False
            time.sleep(0.01)
        return True

    def drives_on(self, after_s: float) -> bool:
        """Wait until the robot is told to move again."""
        return self.wait_for(lambda: any(c.v_mps > MOVING_MPS for c in self._commands.since(after_s)), RECOVERS_S)

    def meet(self, fault: Fault) -> Event:
        """Wait for a random moment at which the robot moves, and meet a fault there."""
        self.wait_for(self._is_moving, RECOVERS_S)
        moment_s = time.monotonic() + self._rng.uniform(0.0, 0.7)
        self.wait_for(lambda: time.monotonic() >= moment_s, RECOVERS_S)
        event = Event(fault, fault.begin(self))
        if fault.end is not None:
            self.wait_for(lambda: time.monotonic() >= event.begin_s + FAULT_S, RECOVERS_S)
            event.end_s = time.monotonic()
            fault.end(self)
        else:
            self.wait_for(lambda: self._commands.first_stop(event.begin_s), ENDS_S)
            self.wait_for(lambda: time.monotonic() >= event.begin_s + STANDS_S, RECOVERS_S)
            self.navigation.close()
            event.end_s = time.monotonic()
        if stop := self._commands.lasting_stop(event.begin_s, event.end_s):
            event.stop_s = stop.at_s
        if fault.end is None:
            self.restart()
        if self.drives_on(event.end_s):
            event.resumed_s = time.monotonic()
        return event

    def _is_moving(self) -> bool:
        """Return whether only commands to move came for so long that the robot has taken a restarted sender for one."""
        newest = self._commands.since(time.monotonic() - MOVING_S)
        return bool(newest) and all(one.v_mps > MOVING_MPS for one in newest)


class Proof:
    """The faults that are still to be met and what was measured; several drives share it."""

    def __init__(self, seeds: Sequence[int]) -> None:
        self._seeds = seeds
        self._pending = [fault for fault in (*PASSING, *ENDING) for _ in seeds]
        random.Random(seeds[0]).shuffle(self._pending)
        self._lock = threading.Lock()
        self._n_drives = 0
        self._left = MAX_TRIES * len(self._pending)
        self.measured: list[Measured] = []
        self.outcomes: list[str] = []

    def drive_all(self, number: int) -> None:
        """Drive until no fault is pending."""
        with Launcher() as launcher:
            while self._pending and self._left > 0:
                with self._lock:
                    seed = self._seeds[self._n_drives % len(self._seeds)]
                    self._n_drives += 1
                with tempfile.TemporaryDirectory() as scratch:
                    self._drive(Path(scratch), launcher, number, seed)

    def _drive(self, folder: Path, launcher: Launcher, number: int, seed: int) -> None:
        rng = random.Random(1000 * number + self._n_drives)
        events: list[Event] = []
        lost: Fault | None = None
        clock = time.time() - time.monotonic()
        with (
            Rig(folder, number, seed, ROBOT, MAX_DRIVE_S) as rig,
            CommandListener(rig.robot_url) as commands,
        ):
            drive = FaultyDrive(rig, launcher, commands, rng)
            drive.restart()
            begin_s = time.monotonic()
            try:
                if not drive.drives_on(begin_s):
                    raise RuntimeError(f"the robot of seed {seed} does not drive off: see {folder}")
                while (lost := self._next()) is not None:
                    events.append(drive.meet(lost))
                    lost = None
                    if events[-1].resumed_s is None:
                        break
            except RobotGoneError:
                pass
            finally:
                drive.navigation.close()
            rig.robot.send_signal(signal.SIGTERM)
            rig.robot.wait(30)
            states = States(folder / "robot", clock)
        self._judge(events, states, commands, lost)

    def _judge(self, events: Sequence[Event], states: States, commands: CommandListener, lost: Fault | None) -> None:
        with self._lock:
            self.outcomes.append(states.outcome)
            for event in events:
                self._left -= 1
                stop_s = event.stop_s
                if event.fault.stops and not states.speed_at(event.begin_s) > MOVING_MPS:
                    self._pending.append(event.fault)
                    continue
                meanwhile = [one for one in commands.since(event.begin_s) if one.at_s < event.end_s]
                self.measured.append(
                    Measured(
                        event.fault.name,
                        event.fault.stops,
                        stop_s - event.begin_s if stop_s is not None else None,
                        *(states.stand(stop_s) if stop_s is not None else (None, None)),
                        contact=states.contact_between(event.begin_s, event.resumed_s or event.end_s),
                        drove_on=event.resumed_s is not None,
                        n_stops=sum(one.is_stop for one in meanwhile),
                    )
                )
            if lost is not None:
                self._pending.append(lost)

    def _next(self) -> Fault | None:
        with self._lock:
            return self._pending.pop() if self._pending else None


def test_safety(targets: Targets, seeds: range, jobs: int) -> None:
    """Meet every fault as many times as there are seeds; print what each did."""
    proof = Proof(seeds)
    begin_s = time.monotonic()
    with ThreadPoolExecutor(jobs) as pool:
        list(pool.map(proof.drive_all, range(FIRST_NUMBER, FIRST_NUMBER + jobs)))
    for fault in (*PASSING, *ENDING):
        is_met, line = lines(fault.name, [one for one in proof.measured if one.name == fault.name], len(seeds))
        targets.check(line, good=is_met)
    ended = {outcome: proof.outcomes.count(outcome) for outcome in sorted(set(proof.outcomes))}
    targets.say(f"{len(proof.outcomes)} drives in {time.monotonic() - begin_s:.0f} s ended: {ended}")
