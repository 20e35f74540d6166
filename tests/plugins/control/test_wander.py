"""Random driving covers what a model has to be taught."""

from __future__ import annotations

import numpy as np
from graphnav_control.wander import Wander

from graphnav import Image, Stamp

IMAGE = Image(pixels=np.zeros((8, 8), np.uint8))


def drive(stage: Wander, seed: int = 0, frames: int = 1500) -> np.ndarray:
    """Return the commands (frames, 2) at 10 Hz."""
    stage.reset(seed)
    twists = [stage.step(IMAGE, Stamp(100_000 * frame)) for frame in range(frames)]
    return np.array([(twist.v_mps, twist.omega_radps) for twist in twists])


def test_it_covers_all_speeds_and_turns_and_stays_within_them() -> None:
    v, omega = drive(Wander(max_speed_mps=0.4, max_turn_radps=1.6)).T
    assert v.min() >= 0.0
    assert v.max() <= 0.4
    assert np.abs(omega).max() <= 1.6
    joint, _, _ = np.histogram2d(v, omega, bins=(4, 4), range=((0.0, 0.4), (-1.6, 1.6)))
    assert (joint > 10).all()


def test_it_often_drives_straight_on() -> None:
    _, omega = drive(Wander()).T
    assert (np.abs(omega) < 0.1).mean() > 0.15


def test_it_drives_smoothly() -> None:
    steps = np.abs(np.diff(drive(Wander(response_s=1.0)), axis=0))
    assert steps[:, 0].max() < 0.4 * 0.1
    assert steps[:, 1].max() < 3.2 * 0.1


def test_the_seed_decides() -> None:
    assert np.array_equal(drive(Wander(), 1, 50), drive(Wander(), 1, 50))
    assert not np.array_equal(drive(Wander(), 1, 50), drive(Wander(), 2, 50))


def test_after_a_gap_it_starts_at_rest() -> None:
    stage = Wander(straight_ratio=0.0)
    assert np.abs(drive(stage, frames=50)[-1]).max() > 0.1
    for now_us in (10_000_000, 5_000_000):
        twist = stage.step(IMAGE, Stamp(now_us))
        assert (twist.v_mps, twist.omega_radps) == (0.0, 0.0)
        for k in range(1, 30):
            twist = stage.step(IMAGE, Stamp(now_us + 100_000 * k))
        assert np.hypot(twist.v_mps, twist.omega_radps) > 0.1
