"""Odometry against the motion that the picture shows: gross faults are named, honest odometry is not accused."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import pytest
from graphnav_odometry.motion import Motion, MotionOutputs
from graphnav_odometry.pose import Pose, arc

import graphnav
from graphnav import Flow, Mount, Odometry, Since, Stamp

FRAME_US, SAMPLE_US, LAG_US = 100_000, 20_000, 40_000
ROWS, COLS, STEP_PX = 30, 40, 4
MOUNT = Mount(1.0, 75.0, 70.0, 0.0)


class Way(NamedTuple):
    """A drive that goes straight for a second and turns for a second, in turns."""

    v_mps: float = 0.3
    omega_radps: float = 0.4

    def turning(self, us: int) -> float:
        return self.omega_radps if us // 1_000_000 % 2 else 0.0

    def pose(self, us: int) -> Pose:
        pose, at_us = Pose(0.0, 0.0, 0.1), 0
        while at_us < us:
            until_us = min((at_us // 1_000_000 + 1) * 1_000_000, us)
            s = (until_us - at_us) * 1e-6
            pose = pose.then(arc(self.v_mps * s, 0.0, self.turning(at_us) * s))
            at_us = until_us
        return pose


def flow_at(way: Way, us: int, height_m: float = 1.0, obstacle: float = 1.0, noise_px: float = 0.02) -> Flow:
    """Return the flow of a frame; ``obstacle``: how many times as fast as the floor the left half flows."""
    moved = way.pose(us).seen_from(way.pose(us - FRAME_US))
    motion = graphnav.Motion(forward_m=moved.x_m, left_m=moved.y_m, turn_rad=moved.yaw_rad, interval_us=FRAME_US)
    valid = np.ones((ROWS, COLS), np.uint8)
    blank = Flow(uv_px=np.zeros((ROWS, COLS, 2), np.float32), valid=valid, interval_us=FRAME_US, step_px=STEP_PX)
    uv_px = Mount(height_m, 75.0, 70.0, 0.0).floor_moved_px(blank, motion).reshape(ROWS, COLS, 2)
    uv_px[:, : COLS // 2] *= obstacle
    uv_px += noise_px * np.random.default_rng(us).standard_normal(uv_px.shape)
    return Flow(uv_px=uv_px.astype(np.float32), valid=valid, interval_us=FRAME_US, step_px=STEP_PX)


Told = Callable[[int, Pose], Pose]
HONEST: Told = lambda us, pose: pose  # noqa: E731


def drive(
    told: Told = HONEST, seconds: float = 6.0, way: Way | None = None, flow: Callable[[int], Flow] | None = None
) -> list[MotionOutputs]:
    """Return what comes of odometry that tells ``told`` of the true pose."""
    stage, found = Motion(), []
    way = way or Way()
    stage.reset(seed=0)
    sent_us = 0
    for us in range(FRAME_US, round(seconds * 1e6), FRAME_US):
        stamps = range(sent_us, us + LAG_US, SAMPLE_US)
        sent_us = stamps[-1] + SAMPLE_US
        samples = []
        for at_us in stamps:
            pose = told(at_us, way.pose(at_us))
            sample = Odometry(x_m=pose.x_m, y_m=pose.y_m, yaw_rad=_wrapped(pose.yaw_rad), v_mps=0.0, omega_radps=0.0)
            samples.append((at_us, sample))
        found.append(stage.step(flow(us) if flow else flow_at(way, us), Since(tuple(samples)), Stamp(us)))
    return found


def _wrapped(yaw_rad: float) -> float:
    return math.remainder(yaw_rad, 2 * math.pi)


def faults(found: Sequence[MotionOutputs]) -> set[str]:
    return {one.check.fault for one in found} - {""}


def in_degrees(_us: int, pose: Pose) -> Pose:
    return pose._replace(yaw_rad=math.degrees(pose.yaw_rad))


FAULTS: dict[str, tuple[str, Told, Way]] = {
    "always 0": ("motionless", lambda us, pose: Pose(0.0, 0.0, 0.0), Way()),
    "no turn": ("motionless", lambda us, pose: pose._replace(yaw_rad=0.0), Way(v_mps=0.1)),
    "turns the wrong way": ("reversed", lambda us, pose: pose._replace(yaw_rad=-pose.yaw_rad), Way(v_mps=0.0)),
    "a gentle turn the wrong way": (
        "reversed",
        lambda us, pose: pose._replace(yaw_rad=-pose.yaw_rad),
        Way(omega_radps=0.12),
    ),
    "drives the wrong way": ("reversed", lambda us, pose: Pose(-pose.x_m, -pose.y_m, pose.yaw_rad), Way()),
    "degrees": ("scale", in_degrees, Way(omega_radps=0.2)),
    "millimetres, slowly": ("scale", lambda us, p: Pose(1e3 * p.x_m, 1e3 * p.y_m, p.yaw_rad), Way(v_mps=0.004)),
    "jump": ("jump", lambda us, pose: pose._replace(x_m=pose.x_m + (100.0 if us > 2_000_000 else 0.0)), Way()),
    "turn jump": ("turn_jump", lambda us, p: p._replace(yaw_rad=p.yaw_rad + (us > 2_000_000) * 2.0), Way()),
    "fast turn in degrees": ("turn_jump", in_degrees, Way(omega_radps=1.0)),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_gross_fault_is_named_and_the_motion_is_not_used(name: str) -> None:
    expected, told, way = FAULTS[name]
    if name == "millimetres, slowly":
        found = drive(told, way=way, flow=lambda us: flow_at(Way(v_mps=0.05, omega_radps=way.omega_radps), us))
    else:
        found = drive(told, way=way)
    assert expected in faults(found)
    assert all(one.motion is None for one in found if one.check.fault)
    assert not any(one.check.agrees for one in found if one.check.fault)


def test_a_jump_is_told_in_metres_for_a_second_and_then_forgotten() -> None:
    found = drive(FAULTS["jump"][1])
    wrong = [one.check for one in found if one.check.fault]
    assert len(wrong) == 10
    assert wrong[0].value == pytest.approx(100.0, abs=0.1)
    assert wrong[0].limit == pytest.approx(0.1)
    assert found[-1].motion is not None
    assert found[-1].check.agrees


@pytest.mark.parametrize("omega_radps", [0.4, -0.4])
@pytest.mark.parametrize("new_rad", [2.0, -2.0, 0.6])
def test_a_new_heading_while_the_robot_turns_is_a_jump_and_forgotten(omega_radps: float, new_rad: float) -> None:
    way = Way(omega_radps=omega_radps)
    at = way.pose(1_500_000)
    turned = Pose(at.x_m, at.y_m, at.yaw_rad + new_rad)
    found = drive(lambda us, pose: turned.then(pose.seen_from(at)) if us > 1_500_000 else pose, way=way)
    assert faults(found) == {"turn_jump"}
    assert sum(bool(one.check.fault) for one in found) == 10
    assert found[30].check.agrees


HONEST_ODOMETRY: dict[str, Told] = {
    "exact": HONEST,
    "2 % of scale": lambda us, pose: Pose(1.02 * pose.x_m, 1.02 * pose.y_m, pose.yaw_rad),
    "20 % of slip": lambda us, pose: Pose(1.25 * pose.x_m, 1.25 * pose.y_m, pose.yaw_rad),
    "noise of 3 mm": lambda us, pose: pose._replace(x_m=pose.x_m + 0.003 * math.sin(us)),
    "drift of 1 degree a second": lambda us, pose: pose._replace(yaw_rad=pose.yaw_rad + math.radians(us * 1e-6)),
    "100 ms late": lambda us, pose: Way().pose(max(us - 100_000, 0)),
}


@pytest.mark.parametrize("name", HONEST_ODOMETRY)
@pytest.mark.parametrize(("height_m", "obstacle"), [(1.0, 1.0), (1.0, 1.6), (0.85, 1.0), (1.15, 1.4)])
def test_honest_odometry_is_not_accused(name: str, height_m: float, obstacle: float) -> None:
    found = drive(HONEST_ODOMETRY[name], flow=lambda us: flow_at(Way(), us, height_m, obstacle))
    assert faults(found) == set()
    assert sum(one.motion is None for one in found) == 0
    assert found[-1].check.agrees


@pytest.mark.parametrize("noise_px", [0.0, 0.03])
def test_a_picture_that_does_not_move_accuses_no_odometry(noise_px: float) -> None:
    standing = Way(v_mps=0.0, omega_radps=0.0)
    found = drive(flow=lambda us: flow_at(standing, us, noise_px=noise_px))
    assert faults(found) == set()
    assert not any(one.check.agrees for one in found)


def test_a_robot_that_stands_agrees_with_nothing() -> None:
    standing = Way(v_mps=0.0, omega_radps=0.0)
    found = drive(way=standing)
    assert faults(found) == set()
    assert not any(one.check.agrees for one in found)


def test_wrong_turns_agree_only_by_turning() -> None:
    def told(us: int, pose: Pose) -> Pose:
        return pose._replace(yaw_rad=-pose.yaw_rad) if us < 2_000_000 else pose._replace(yaw_rad=pose.yaw_rad + 1.0)

    found = drive(told, seconds=9.0, way=Way(v_mps=0.1))
    wrong = next(k for k, one in enumerate(found) if one.check.fault == "reversed")
    agreed = next(k for k, one in enumerate(found) if k > wrong and one.check.agrees)
    assert found[wrong].check.value == pytest.approx(-1.0, abs=0.2)
    assert (agreed + 1) * FRAME_US > 3_000_000  # where it turns again


def test_a_flow_without_valid_vectors_says_nothing() -> None:
    def flow(us: int) -> Flow:
        found = flow_at(Way(), us)
        found.valid[:] = 0
        return found

    found = drive(FAULTS["always 0"][1], flow=flow)
    assert faults(found) == set()
