"""Adverse viewing conditions: low contrast, changing light, motion blur, a visible horizon."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from graphnav_world.world import Pymunk, WorldOutputs

from graphnav import Latest, Stamp, Twist
from graphnav.arrays import Doubles

TICK_S = 0.1
AHEAD = Twist(v_mps=0.4, omega_radps=0.0)


def drive(map_file: Path, twist: Twist = AHEAD, ticks: int = 8, **params: Any) -> list[WorldOutputs]:
    world = Pymunk(map=map_file, **{"noise_sigma_gray": 0.0} | params)
    world.reset(3)
    return [world.step(Latest(twist, TICK_S), Stamp(round(k * TICK_S * 1e6))) for k in range(ticks)]


def pictures(outputs: list[WorldOutputs]) -> Doubles:
    return np.stack([out.image.pixels for out in outputs]).astype(np.float64)


@pytest.mark.parametrize("ratio", [0.25, 0.5])
def test_contrast_scales_textures_about_their_mean(ratio: float, maps: Path) -> None:
    full, pale, blank = (pictures(drive(maps / "empty.yaml", contrast_ratio=r)) for r in (1.0, ratio, 0.0))
    assert np.ptp(blank) == 0.0
    np.testing.assert_allclose(pale - blank, ratio * (full - blank), atol=2.0)


def test_the_light_swings_as_a_sine_of_time(maps: Path) -> None:
    steady, swinging = (
        pictures(drive(maps / "empty.yaml", ticks=20, light_ratio=0.6, light_swing_ratio=swing, light_period_s=0.8))
        for swing in (0.0, 0.4)
    )
    expected = [1 + 0.4 * math.sin(2 * math.pi * k * TICK_S / 0.8) for k in range(20)]
    assert swinging.mean(axis=(1, 2)) / steady.mean(axis=(1, 2)) == pytest.approx(expected, rel=0.01)


def test_blur_smears_along_the_motion_and_leaves_everything_where_it_is(maps: Path) -> None:
    sharp, blurred = (drive(maps / "empty.yaml", exposure_s=s)[-1] for s in (0.0, 0.08))
    one, other = (out.image.pixels.astype(np.float64) for out in (sharp, blurred))
    along, across = (np.abs(np.diff(other, axis=k)).mean() / np.abs(np.diff(one, axis=k)).mean() for k in (0, 1))
    assert along < 0.75
    assert along < across - 0.15
    slope = np.gradient(other, axis=0)
    shift_px = (slope * (one - other)).sum() / (slope * slope).sum()
    assert abs(shift_px) < 0.1, "the frame's stamp is the middle of the exposure"


def test_blur_is_that_of_a_box_as_long_as_the_way_during_the_exposure(maps: Path) -> None:
    sharp, blurred = (drive(maps / "empty.yaml", tilt_deg=90.0, exposure_s=s)[-1] for s in (0.0, 0.1))
    assert sharp.truth is not None
    length_px = sharp.truth.flow_px[60, 80, 1]
    assert length_px == pytest.approx(4.6, abs=0.1)
    box = np.zeros(15)
    box[np.arange(15)] = np.clip(length_px / 2 + 0.5 - np.abs(np.arange(15) - 7), 0, 1) / length_px
    expected = cv2.filter2D(sharp.image.pixels.astype(np.float64), -1, box[:, None])
    inside = np.s_[10:-10, 10:-10]
    left = np.abs(blurred.image.pixels[inside] - expected[inside]).mean()
    without = np.abs(blurred.image.pixels[inside] - sharp.image.pixels[inside].astype(float)).mean()
    assert left < 0.25 * without


def test_blur_leaves_the_truth_alone_and_a_robot_that_stands_sharp(maps: Path) -> None:
    sharp, blurred = (drive(maps / "crossing.yaml", exposure_s=s)[-1] for s in (0.0, 0.1))
    assert sharp.truth is not None
    assert blurred.truth is not None
    for field in ("obstacle", "depth_m", "flow_px"):
        assert np.array_equal(getattr(sharp.truth, field), getattr(blurred.truth, field))
    rest = Twist(v_mps=0.0, omega_radps=0.0)
    one, other = (pictures(drive(maps / "approach.yaml", rest, 2, exposure_s=s)) for s in (0.0, 0.1))
    assert np.abs(one - other).max() <= 1.0


def test_conditions_repeat_and_leave_the_drive_alone(maps: Path) -> None:
    conditions: dict[str, Any] = {"contrast_ratio": 0.3, "light_swing_ratio": 0.3, "exposure_s": 0.05}
    plain = drive(maps / "crossing.yaml")
    one, same = (drive(maps / "crossing.yaml", **conditions) for _ in range(2))
    assert np.array_equal(pictures(one), pictures(same))
    assert not np.array_equal(pictures(one), pictures(plain))
    assert [out.state.x_m for out in one] == [out.state.x_m for out in plain]


def test_above_the_horizon_there_is_neither_ground_nor_obstacle(maps: Path) -> None:
    out = drive(maps / "empty.yaml", tilt_deg=20.0)[-1]
    assert out.truth is not None
    sky = np.isinf(out.truth.depth_m)
    rows_above = 59.5 - 80 / math.tan(math.radians(35)) * math.tan(math.radians(20))
    assert sky[: math.ceil(rows_above)].all()
    assert not sky[math.ceil(rows_above) :].any()
    assert not out.truth.obstacle.any()


def test_the_floor_does_not_flicker_on_its_way_to_the_horizon(maps: Path) -> None:
    outputs = drive(maps / "empty.yaml", ticks=9, tilt_deg=20.0)
    before, now = outputs[-2].image.pixels.astype(np.float32), outputs[-1]
    assert now.truth is not None
    x, y = np.meshgrid(np.arange(160, dtype=np.float32), np.arange(120, dtype=np.float32))
    came_from = np.stack([x, y], axis=-1) - now.truth.flow_px
    warped = cv2.remap(before, came_from, None, cv2.INTER_CUBIC)
    far = np.s_[20:36, 12:-12]
    flicker = np.abs(warped - now.image.pixels)[far].mean()
    assert flicker < 4.0, "gray levels; with too few mip levels it is 12"
