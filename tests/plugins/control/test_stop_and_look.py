"""It turns only when it stands, and believes only what it saw while it drove straight on."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from graphnav_control.stop_and_look import StopAndLook
from graphnav_world.vehicle import Limits, Vehicle

from graphnav import ParamError, Stamp, Steering, Twist
from graphnav.testing import check_stage

FRAME_US = 100_000


def asked(theta_rad: float) -> Steering:
    force = np.array([-math.sin(theta_rad), math.cos(theta_rad)])
    return Steering(repulsive=np.zeros(2), guiding=force, control=force, theta_rad=theta_rad, eigenvalues=np.zeros(2))


def drive(stage: StopAndLook, theta_of: Callable[[int], float], frames: int, seed: int = 0) -> list[Twist]:
    """Return the commands of so many frames; ``theta_of``: what steering says in each."""
    stage.reset(seed)
    return [stage.step(asked(theta_of(frame)), Stamp(FRAME_US * (frame + 1))) for frame in range(frames)]


def turned_rad(twists: list[Twist]) -> float:
    return sum(twist.omega_radps for twist in twists) * FRAME_US * 1e-6


@pytest.mark.parametrize("seed", range(5))
def test_it_never_drives_and_turns_at_once(seed: int) -> None:
    thetas = np.random.default_rng(seed).uniform(-math.pi, math.pi, 200)
    for twist in drive(StopAndLook(max_speed_mps=0.4, max_turn_radps=1.0), lambda k: float(thetas[k]), 200):
        assert (twist.v_mps, twist.omega_radps) == (0.4, 0.0) or twist.v_mps == 0.0
        assert abs(twist.omega_radps) <= 1.0 + 1e-9


def test_straight_ahead_it_drives_on() -> None:
    for twist in drive(StopAndLook(), lambda _: 0.05, 50):
        assert (twist.v_mps, twist.omega_radps) == (0.3, 0.0)


@pytest.mark.parametrize("theta_rad", [-1.5, -0.3, 0.2, 1.0, 1.5])
def test_a_turn_is_the_asked_share_of_theta(theta_rad: float) -> None:
    stage = StopAndLook(turn_ratio=0.6)
    twists = drive(stage, lambda k: theta_rad if k < 5 else 0.0, 40)
    assert turned_rad(twists) == pytest.approx(0.6 * theta_rad)


def test_what_steering_says_while_the_drive_settles_and_during_turns_is_not_heard() -> None:
    stage = StopAndLook(settle_s=0.2, look_frames=2, turn_ratio=1.0)
    # The first command stands from frame 0 on; the flow of frame 3 is the first that begins 0.2 s later.
    right, wrong = 0.5, -1.5
    twists = drive(stage, lambda k: right if k in (3, 4) else wrong, 8)
    assert [twist.v_mps for twist in twists[:4]] == [0.3] * 4
    turning = twists[4:]
    assert all(twist.omega_radps > 0 for twist in turning)
    assert turned_rad(twists) > 0


def test_frames_are_judged_by_their_median() -> None:
    stage = StopAndLook(settle_s=0.0, look_frames=3, turn_ratio=1.0)
    said = {1: 0.3, 2: -1.5, 3: 0.2}
    assert turned_rad(drive(stage, lambda k: said.get(k, 0.0), 20)) == pytest.approx(0.2)


def test_a_blocked_way_is_not_driven_on_to_the_end_of_the_look() -> None:
    stage = StopAndLook(settle_s=0.0, look_frames=10)
    twists = drive(stage, lambda k: 2.0 if k == 2 else 0.0, 4)
    assert [twist.v_mps for twist in twists] == [0.3, 0.3, 0.0, 0.0]


@pytest.mark.parametrize("theta_rad", [0.3, 1.2, 3.0])
def test_the_robot_turns_by_that_much_and_every_judged_frame_was_driven_straight(theta_rad: float) -> None:
    vehicle = Vehicle([], (0.0, 0.0, 0.0), 0.2, Limits(0.5, 2.0, 0.25, 0.25))
    stage = StopAndLook(settle_s=0.2, look_frames=3, turn_ratio=0.5)
    stage.reset(0)
    poses = [vehicle.pose]
    frames_judged = 1 if theta_rad > math.pi / 2 else 3
    twist, turns = Twist(v_mps=0.0, omega_radps=0.0), 0
    for frame in range(1, 60):
        poses.append(vehicle.advance(twist.v_mps, twist.omega_radps, 0.1 * frame))
        was, twist = twist, stage.step(asked(theta_rad if not turns else 0.0), Stamp(FRAME_US * frame))
        if twist.omega_radps and not was.omega_radps:
            turns += 1
            judged = poses[-1 - frames_judged :]
    assert turns == 1
    assert poses[-1].yaw_rad == pytest.approx(0.5 * theta_rad, rel=0.25 if theta_rad < 1 else 0.05)
    steps_m = np.diff([pose.x_m for pose in judged])
    assert steps_m == pytest.approx(0.03, rel=1e-6)
    assert {pose.yaw_rad for pose in judged} == {0.0}


def test_frames_that_were_dropped_do_not_matter() -> None:
    stage = StopAndLook(settle_s=0.2, look_frames=1, turn_ratio=1.0)
    stage.reset(0)
    seen = [stage.step(asked(0.8), Stamp(FRAME_US * k)) for k in (1, 2, 5)]
    assert [twist.v_mps for twist in seen] == [0.3, 0.3, 0.3]
    assert stage.step(asked(0.8), Stamp(FRAME_US * 6)).v_mps == 0.0


def test_reset_forgets_the_turn() -> None:
    stage = StopAndLook()
    first, again = ([twist.omega_radps for twist in drive(stage, lambda _: 1.0, 7)] for _ in range(2))
    assert first[-1] > 0
    assert again == first


def test_the_stage_keeps_its_contract() -> None:
    check_stage(StopAndLook, *({"steering": asked(1.0), "now": Stamp(FRAME_US * k)} for k in range(1, 12)))


def test_a_turn_of_nothing_is_refused() -> None:
    with pytest.raises(ParamError, match="turn_ratio"):
        StopAndLook(turn_ratio=0.0)


def test_after_a_gap_it_looks_again() -> None:
    stage = StopAndLook(settle_s=0.2, look_frames=1, turn_ratio=1.0, max_turn_radps=0.5)
    twists = drive(stage, lambda _: 1.5, 6)
    assert twists[-1].omega_radps > 0.0
    after_us = FRAME_US * 6 + 5 * FRAME_US
    later = [stage.step(asked(1.5), Stamp(after_us + FRAME_US * k)) for k in range(4)]
    assert [(twist.v_mps, twist.omega_radps) for twist in later[:3]] == [(0.3, 0.0)] * 3
    assert later[3].omega_radps > 0.0
