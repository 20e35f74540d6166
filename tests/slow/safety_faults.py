"""The faults that a live drive has to survive: what begins each and what ends it."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

from testbed.rig import Rig

from .launched import Launched
from .stages.faulty_stages import MODES, STAGES

PATIENCE_S = 10.0


class Drive(Protocol):
    """The target of a fault."""

    rig: Rig
    navigation: Launched
    fault_file: Path

    def wait_for(self, holds: Callable[[], object], within_s: float) -> bool:
        """Return whether something came to hold; raise where the robot's run ends before."""


@dataclass(frozen=True)
class Fault:
    """``begin`` returns when it began, monotonic seconds.

    ``end``: None for a fault that ends the navigation's process. ``stops``: whether it has to stop the robot.
    """

    name: str
    begin: Callable[[Drive], float]
    end: Callable[[Drive], None] | None = None
    stops: bool = True


def _tell(fault: Mapping[str, object], drive: Drive) -> float:
    now_s = time.monotonic()
    drive.rig.fault(fault)
    return now_s


def _kill_camera(drive: Drive) -> float:
    now_s = time.monotonic()
    drive.rig.kill_camera()
    return now_s


def _pause_camera(drive: Drive) -> float:
    now_s = time.monotonic()
    drive.rig.pause_camera()
    return now_s


def _send(number: signal.Signals, drive: Drive) -> float:
    now_s = time.monotonic()
    drive.navigation.send(number)
    return now_s


def _resume(drive: Drive) -> None:
    drive.navigation.send(signal.SIGCONT)


def _misbehave(stage: str, mode: str, drive: Drive) -> float:
    """Let a stage misbehave at its next step; return when it began to."""
    begun = Path(f"{drive.fault_file}.begun")
    begun.unlink(missing_ok=True)
    part = drive.fault_file.with_suffix(".part")
    part.write_text(f"{stage} {mode}", encoding="utf-8")
    part.rename(drive.fault_file)
    try:
        if not drive.wait_for(begun.exists, PATIENCE_S):
            raise TimeoutError(f"{stage} does not step")
    finally:
        drive.fault_file.unlink()
    return float(begun.read_text(encoding="utf-8"))


_TOLD: tuple[tuple[str, Mapping[str, object], bool], ...] = (
    ("edge delayed by 1.0 s", {"delay_s": 1.0}, True),
    ("half of the images lost", {"drop": "half"}, False),
    ("one image repeated", {"repeat": True}, True),
    ("picture white", {"picture": "white"}, True),
    ("lens covered", {"picture": "covered"}, True),
    ("sender's clock +3600 s", {"jump_s": 3600.0}, True),
    ("sender's clock -3600 s", {"jump_s": -3600.0}, True),
)
PASSING = (
    Fault("camera killed", _kill_camera, lambda drive: drive.rig.start_camera()),
    Fault("camera suspended (SIGSTOP)", _pause_camera, lambda drive: drive.rig.resume_camera()),
    *(Fault(name, partial(_tell, fault), lambda drive: drive.rig.fault({}), stops) for name, fault, stops in _TOLD),
    Fault("run suspended (SIGSTOP)", partial(_send, signal.SIGSTOP), _resume),
)
ENDING = (
    *(Fault(f"{stage} {mode}", partial(_misbehave, stage, mode)) for mode in MODES for stage in STAGES),
    *(
        Fault(number.name, partial(_send, number))
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGSEGV, signal.SIGKILL)
    ),
)
