"""In lockstep the guard changes nothing while the robot sees, and stops it when it does not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from graphnav import GuardState, Recording, State, Twist
from graphnav.arrays import Doubles
from graphnav.core.runner.recording.summary import Summary

Drive = Callable[..., tuple[Summary, Recording]]


def speeds(log: Recording, channel: str) -> Doubles:
    """Return stamp, speed and turning rate of every twist, (n, 3)."""
    rows = []
    for utime, _, twist in log.messages(channel):
        assert isinstance(twist, Twist)
        rows.append((utime, twist.v_mps, twist.omega_radps))
    return np.array(rows)


def states(log: Recording) -> list[GuardState]:
    found = [message for _, _, message in log.messages("guard.state")]
    assert all(isinstance(state, GuardState) for state in found)
    return found  # type: ignore[return-value]


@pytest.mark.parametrize("graph", ["corridor_ccw", "pillars", "approach", "paper_corridor_cw", "measure_detectors"])
def test_every_command_leaves_bit_for_bit(graph: str, drive: Drive) -> None:
    _, log = drive(graph, 1004, "run.until_s=4")
    with log:
        given, left = speeds(log, "control.twist"), speeds(log, "guard.twist")
        assert given.tobytes() == left[:-1].tobytes()
        assert not left[-1, 1:].any(), "the recording ends with a stop"
        assert len(left) > 35
        assert all(state.may_move for state in states(log))


@pytest.mark.parametrize(
    "blinding", ["robot.contrast_ratio=0", "guard.min_contrast_gray=255", "guard.min_judged_ratio=1"]
)
def test_a_robot_that_sees_nothing_stands(blinding: str, drive: Drive) -> None:
    _, log = drive("corridor_ccw", 1004, "run.until_s=2", blinding)
    with log:
        assert not speeds(log, "guard.twist")[:, 1:].any()
        assert all("blind" in state.causes and not state.may_move for state in states(log))
        poses = [message for _, _, message in log.messages("robot.state")]
        first, last = poses[0], poses[-1]
        assert isinstance(first, State)
        assert isinstance(last, State)
        assert (first.x_m, first.y_m, first.yaw_rad) == (last.x_m, last.y_m, last.yaw_rad)


FREEZING = """
from graphnav import Image, Stage, Stamp, hookimpl, param


class Picture(Stage):
    \"\"\"Repeats its picture from a time on, under new stamps.\"\"\"

    at_s: float = param(2.0, doc="when it begins to")

    def reset(self, seed: int) -> None:
        self._kept = None

    def step(self, image: Image, utime: Stamp) -> Image:
        if utime < self.at_s * 1e6 or self._kept is None:
            self._kept = image
        return self._kept


@hookimpl
def graphnav_stages():
    return [Picture]
"""


@pytest.mark.long
@pytest.mark.parametrize("graph", ["corridor_ccw", "navigate"])
def test_a_robot_whose_picture_freezes_stands_and_stays(graph: str, drive: Drive, tmp_path: Path) -> None:
    (tmp_path / "freezing.py").write_text(FREEZING)
    (tmp_path / "frozen.yaml").write_text(
        f"extends: {graph}\n"
        "plugins: [freezing.py]\n"
        "stages:\n"
        "  camera: {use: freezing.picture, in: {image: robot.image}}\n"
        "  flow: {in: {image: camera.image}}\n"
        "  guard: {in: {image: camera.image}}\n"
    )
    ways_m = []
    for frozen_px in (0.1, 0.0):
        _, log = drive(str(tmp_path / "frozen.yaml"), 3, "run.until_s=7", f"guard.frozen_px={frozen_px}")
        with log:
            way = [message for utime, _, message in log.messages("robot.state") if utime > 2_000_000]
            ways_m.append(sum(0.1 * abs(state.v_mps) for state in way if isinstance(state, State)))
            held = states(log)[-1]
        assert (held.stopped, held.causes) == ((True, ("frozen",)) if frozen_px else (False, ()))
    assert ways_m[0] <= 0.15 + 0.04 + 0.1  # before the stop, braking, the retry
    assert ways_m[1] > 0.5  # on, `navigate` into a wall
