"""The stages of ``navigate_live``, each of which raises, hangs or holds the GIL when a file says so.

The environment variable ``FAULT_FILE`` names the file; it holds the stage's name and what it is to do: ``plane hang``.
When the stage does it, it first writes the monotonic time to ``FAULT_FILE.begun``.
"""

from __future__ import annotations

import ctypes
import functools
import os
import time
from pathlib import Path
from typing import Any, NoReturn

from graphnav_control.guard import Guard
from graphnav_control.nonholonomic import Nonholonomic
from graphnav_flow.lucas_kanade import LucasKanade
from graphnav_odometry.motion import Motion
from graphnav_planar.motion import Motion as PlanarMotion
from graphnav_plane.ica import Ica
from graphnav_steer.pca import Pca

from graphnav import Stage, hookimpl

FAMILY = "faulty"
FAULT_FILE = "FAULT_FILE"
STAGES: dict[str, type[Stage]] = {
    "flow": LucasKanade,
    "motion": Motion,
    "planar": PlanarMotion,
    "plane": Ica,
    "steer": Pca,
    "control": Nonholonomic,
    "guard": Guard,
}
MODES = ("raises", "hangs", "holds the GIL")


def _faulty(name: str, base: Any) -> type[Stage]:
    """Return a subclass that steps as ``base`` does until it is told otherwise."""

    @functools.wraps(base.step)
    def step(self: Any, *args: Any, **inputs: Any) -> Any:
        _obey(name)
        return base.step(self, *args, **inputs)

    return type(name.capitalize(), (base,), {"step": step, "__doc__": base.__doc__, "__module__": __name__})


def _obey(name: str) -> None:
    """Do what the fault's file tells this stage to do, if it does."""
    path = os.environ.get(FAULT_FILE, "")
    if not os.path.exists(path):
        return
    stage, _, mode = Path(path).read_text(encoding="utf-8").partition(" ")
    if stage == name:
        begun = Path(f"{path}.part")
        begun.write_text(repr(time.monotonic()), encoding="utf-8")
        begun.rename(f"{path}.begun")
        _misbehave(mode)


def _misbehave(mode: str) -> NoReturn:
    if mode == "raises":
        raise RuntimeError("told to raise")
    sleep = ctypes.PyDLL(None).usleep if mode == "holds the GIL" else _sleep_us
    while True:
        sleep(900_000)


def _sleep_us(duration_us: int) -> None:
    time.sleep(duration_us * 1e-6)


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages."""
    return [_faulty(name, base) for name, base in STAGES.items()]
