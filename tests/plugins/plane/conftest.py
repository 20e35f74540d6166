"""Scenes whose flow is known: a floor, obstacles that move more than the floor does, and noise as flow has it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import cv2
import numpy as np
import pytest

from graphnav import Flow, Planar, Stamp
from graphnav.arrays import Bools, Doubles

ROWS, COLS, STEP_PX = 30, 40, 4
INTERVAL_US = 100_000


@dataclass(frozen=True)
class Scene:
    """A frame: its flow, its planar flow and which cells are obstacle."""

    flow: Flow
    planar: Planar
    obstacle: Bools


class Scenes:
    """Frames of a camera that looks down on a floor, on cells of 4 px."""

    def __init__(self) -> None:
        self._stamps = count(0, INTERVAL_US)

    def stamp(self) -> Stamp:
        """Return the stamp of the next frame, one interval after the last."""
        return Stamp(next(self._stamps))

    def floor(self, drive_px: float, turn_rad: float, rows: int = ROWS, cols: int = COLS) -> Doubles:
        """Return the flow of the floor: down the picture, faster towards the bottom, and around its middle."""
        y, x = np.mgrid[:rows, :cols] * STEP_PX - np.array([2 * rows, 2 * cols])[:, None, None]
        near = 1 + 0.3 * y / (2 * ROWS)
        return np.stack([drive_px * 0.002 * x + turn_rad * y, drive_px * near - turn_rad * x], axis=-1)

    def scene(
        self,
        share: float = 0.0,
        drive_px: float = 3.0,
        turn_rad: float = 0.0,
        noise_px: float = 0.05,
        gain: float = 1.0,
        seed: int = 0,
    ) -> Scene:
        """Return a frame with an obstacle at the right, 10 to 40 % nearer than the floor, over this share of it.

        ``noise_px`` is smooth over some cells, as the noise of windowed flow is. ``gain``: flow of the floor by planar
        flow, what odometry errs by.
        """
        rng = np.random.default_rng(seed)
        planar = self.floor(drive_px, turn_rad)
        obstacle = np.broadcast_to(np.arange(COLS) >= COLS - round(share * COLS), (ROWS, COLS))
        height = np.broadcast_to(np.linspace(0.4, 0.1, ROWS)[:, None], (ROWS, COLS))
        parallax = np.where(obstacle, height, 0.0)[..., None] * self.floor(drive_px, 0.0)
        noise = np.stack([cv2.GaussianBlur(rng.normal(0, 1, (ROWS, COLS)), (0, 0), 1.0) for _ in range(2)], axis=-1)
        uv_px = gain * planar + parallax + noise * (noise_px / noise.std() if noise_px else 0.0)
        return Scene(self.flow(uv_px), self.planar(planar), obstacle)

    def flow(self, uv_px: Doubles) -> Flow:
        """Return these vectors as a flow that is valid everywhere."""
        valid = np.ones(uv_px.shape[:2], np.uint8)
        return Flow(uv_px=uv_px.astype(np.float32), valid=valid, interval_us=INTERVAL_US, step_px=STEP_PX)

    def planar(self, uv_px: Doubles) -> Planar:
        """Return these vectors as a planar flow that was taught everywhere."""
        valid = np.ones(uv_px.shape[:2], np.uint8)
        return Planar(
            planar_uv_px=uv_px.astype(np.float32),
            planar_valid=valid,
            residual_px=np.full(valid.shape, 0.05, np.float32),
            interval_us=INTERVAL_US,
            step_px=STEP_PX,
        )


@pytest.fixture(scope="session")
def scenes() -> Scenes:
    return Scenes()
