"""A pinhole camera that drives over an endless floor: its exact flow, and models taught from it."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from graphnav_planar.teach import Teach

from graphnav import Flow, Motion, PlanarModel
from graphnav.arrays import Doubles
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter

ROWS, COLS, STEP_PX = 30, 40, 4
FOCAL_PX = 80 / math.tan(math.radians(35))
TILT_RAD = math.radians(75)
INTERVAL_US = 100_000
FRAMES = 200
"""Frames of a drive; models of components, which take a while, are published after the last one only."""


class Floor:
    """An endless floor, 1 m below a camera that is tilted by 75 degrees, on cells of 4 px."""

    def uv_px(
        self, forward_m: float, turn_rad: float, pitch_rad: float = 0.0, roll_rad: float = 0.0, rise_m: float = 0.0
    ) -> Doubles:
        """Return the exact flow (rows, cols, 2) of an arc of this length and turn, on which the camera moves, too.

        ``pitch_rad``, ``roll_rad``: rotations about the axes right and down of the camera. ``rise_m``: how much higher
        it was before.
        """
        y, x = np.mgrid[:ROWS, :COLS] * STEP_PX + 1.5 - np.array([59.5, 79.5])[:, None, None]
        tilt_c, tilt_s = math.cos(TILT_RAD), math.sin(TILT_RAD)
        down = tilt_s + y / FOCAL_PX * tilt_c
        ahead, left = (tilt_c - y / FOCAL_PX * tilt_s) / down, -x / FOCAL_PX / down
        c, s = math.cos(turn_rad), math.sin(turn_rad)
        ahead_then = c * ahead - s * left + forward_m * math.cos(turn_rad / 2)
        left_then = s * ahead + c * left + forward_m * math.sin(turn_rad / 2)
        height_m = 1.0 + rise_m
        right, low = -left_then, height_m * tilt_c - ahead_then * tilt_s
        depth = ahead_then * tilt_c + height_m * tilt_s
        c, s = math.cos(pitch_rad), math.sin(pitch_rad)
        low, depth = c * low - s * depth, s * low + c * depth
        c, s = math.cos(roll_rad), math.sin(roll_rad)
        right, depth = c * right + s * depth, c * depth - s * right
        return np.stack([x - FOCAL_PX * right / depth, y - FOCAL_PX * low / depth], axis=-1)

    def shake(self, rng: np.random.Generator) -> Doubles:
        """Return how a camera moves on a mast that sways by half a degree: pitch and roll in rad, and height in m."""
        return rng.normal(0.0, (0.008, 0.008, 0.02))

    def motion(self, forward_m: float, turn_rad: float) -> Motion:
        """Return what exact odometry says of the arc."""
        left_m = forward_m * math.sin(turn_rad / 2)
        return Motion(forward_m=forward_m, left_m=left_m, turn_rad=turn_rad, interval_us=INTERVAL_US)

    def flow(self, uv_px: Doubles) -> Flow:
        """Return these vectors as a flow that is valid everywhere."""
        valid = np.ones(uv_px.shape[:2], np.uint8)
        return Flow(uv_px=uv_px.astype(np.float32), valid=valid, interval_us=INTERVAL_US, step_px=STEP_PX)

    def teach(
        self,
        stage: Teach,
        frames: int = FRAMES,
        noise_px: float = 0.0,
        *,
        with_shake: bool = False,
        with_motion: bool = True,
    ) -> PlanarModel | None:
        """Return the last model published on a random drive of which every fourth frame goes straight on."""
        rng = np.random.default_rng(0)
        stage.reset(0)
        last = None
        for frame in range(frames):
            forward_m, turn_rad = rng.uniform(0, 0.04), rng.uniform(-0.16, 0.16) * (frame % 4 > 0)
            shake = self.shake(rng) if with_shake else np.zeros(3)
            uv_px = self.uv_px(forward_m, turn_rad, *shake) + rng.normal(0, noise_px, (ROWS, COLS, 2))
            motion = self.motion(forward_m, turn_rad) if with_motion else None
            last = stage.step(self.flow(uv_px), motion) or last
        return last


@pytest.fixture(scope="session")
def floor() -> Floor:
    return Floor()


@pytest.fixture(scope="session")
def model(floor: Floor) -> PlanarModel:
    """Return a model of all terms, taught from exact flow."""
    taught = floor.teach(Teach())
    assert taught is not None
    return taught


@pytest.fixture(scope="session")
def shaken_model(floor: Floor) -> PlanarModel:
    """Return a model of all terms and four components, taught by a camera that shakes."""
    taught = floor.teach(Teach(components=4, every_frames=FRAMES), noise_px=0.03, with_shake=True)
    assert taught is not None
    return taught


@pytest.fixture(scope="session")
def unaided_model(floor: Floor) -> PlanarModel:
    """Return a model of eight components, taught by a camera that shakes, without odometry."""
    stage = Teach(terms=("mean",), components=8, every_frames=FRAMES)
    taught = floor.teach(stage, noise_px=0.03, with_shake=True, with_motion=False)
    assert taught is not None
    return taught


@pytest.fixture
def save(tmp_path: Path) -> Callable[[PlanarModel], Path]:
    """Return a function that writes a model as ``graphnav teach`` does."""

    def write(model: PlanarModel) -> Path:
        path = tmp_path / "model.lcmlog"
        writer = LogWriter(path)
        writer.write("teach.planar_model", INTERVAL_US, encode(model, INTERVAL_US, 0))
        writer.close()
        return path

    return write
