"""The frame of the panels is the one that tells most, and always the same one."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from graphnav_view.panels.keyframe import (
    MAX_RATIO,
    MAX_SPIN_RADPS,
    MIN_RATIO,
    frame_at,
    from_forward,
    keyframe_utime,
    theta_text,
)
from graphnav_view.signals import Signals

from graphnav import About, Flow, Plane, State, Steering
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter, Recording

Record = Callable[..., Recording]


def test_it_is_pushed_aside_hardest_of_those_that_show_ground_and_obstacle_on_a_straight_way(record: Record) -> None:
    signals = Signals(record(frames=60))
    utime = keyframe_utime(signals)
    assert utime is not None
    frame = frame_at(signals, utime)
    assert frame.steering is not None
    pushes = {
        stamp: abs(steering.repulsive[0])
        for stamp, (plane, steering, state) in signals.joined(Plane, Steering, State)
        if MIN_RATIO <= plane.obstacle_ratio <= MAX_RATIO and abs(state.omega_radps) <= MAX_SPIN_RADPS
    }
    assert len(pushes) > 5
    assert utime in pushes
    assert pushes[utime] >= max(pushes.values()) - 0.01


@pytest.mark.parametrize("kind", ["state", "flow"])
def test_where_nothing_was_detected_it_is_one_in_which_the_robot_drives(tmp_path: Path, kind: str) -> None:
    """As the paper's detector often does: every share is 0, so that all frames are equally far from a quarter.

    A log without the robot's state, as that of a camera, tells it by the flow.
    """
    nothing = np.zeros((3, 4), np.uint8)
    plane = Plane(obstacle=nothing, score=nothing.astype(np.float32), valid=nothing + 1, step_px=4, obstacle_ratio=0.0)
    stage = {"state": "robot", "flow": "flow"}[kind]
    with LogWriter(tmp_path / "run.lcmlog") as log:
        graph = {"stages": {stage: {"use": "world.pymunk"}, "plane": {"use": "plane.ica"}}}
        channels, types = (f"{stage}.{kind}", "plane.plane"), (f"graphnav_lcm.{kind}_t", "graphnav_lcm.plane_t")
        about = About(yaml.safe_dump(graph), "", "", 7, channels, types)
        log.write(About.CHANNEL, 0, encode(about, 0, 0))
        for k, speed in enumerate((0.0, 0.05, 0.14, 0.2, 0.3, 0.3, 0.3, 0.3)):
            state = State(0.0, 0.0, 0.0, speed, 0.0, 0.2, contact=False, at_goal=False, moving=np.zeros((0, 3)))
            flow = Flow(np.full((3, 4, 2), speed, np.float32), nothing + 1, 100_000, 4)
            message = state if kind == "state" else flow
            log.write(channels[0], k * 100_000, encode(message, k * 100_000, k))
            log.write("plane.plane", k * 100_000, encode(plane, k * 100_000, k))
    assert keyframe_utime(Signals(Recording(tmp_path / "run.lcmlog"))) == 400_000


def test_without_planes_it_is_the_middle_one(record: Record) -> None:
    signals = Signals(record(frames=9, without=("plane.plane", "flow.flow")))
    assert keyframe_utime(signals) == 400_000


def test_without_anything_seen_there_is_none(record: Record) -> None:
    unseen = ("plane.plane", "flow.flow", "robot.image", "steer.potential")
    assert keyframe_utime(Signals(record(frames=3, without=unseen))) is None


def test_angles_read_as_degrees_and_side() -> None:
    assert [theta_text(t) for t in (0.0, 0.4, -1.2)] == ["0°", "23° left", "69° right"]
    assert [from_forward(t) for t in (0.001, 0.4)] == ["0°, straight forward", "23° left of forward"]
