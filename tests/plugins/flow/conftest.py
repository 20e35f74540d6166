"""Frame pairs whose flow is known exactly: an analytic pattern, sampled where a warp sends each pixel."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import pytest

from graphnav import Flow, Image, Stage, Stamp
from graphnav.arrays import Bools, Bytes, Doubles

Warp = Callable[[Doubles, Doubles], tuple[Doubles, Doubles]]

INTERVAL_US = 100_000


@pytest.fixture(autouse=True)
def _one_thread() -> None:
    cv2.setNumThreads(1)


class Pattern:
    """A sum of random plane waves, so that it can be sampled anywhere without interpolation.

    Wavelengths from ``shortest`` to 60 units, amplitude growing with the wavelength; mean 128, standard deviation 40.
    """

    def __init__(self, seed: int, shortest: float = 4.0, waves: int = 80) -> None:
        rng = np.random.default_rng(seed)
        wavelength = np.exp(rng.uniform(np.log(shortest), np.log(60), waves))
        angle = rng.uniform(0, 2 * np.pi, waves)
        self._kx = 2 * np.pi / wavelength * np.cos(angle)
        self._ky = 2 * np.pi / wavelength * np.sin(angle)
        self._phase = rng.uniform(0, 2 * np.pi, waves)
        amplitude = np.sqrt(wavelength)
        self._amplitude = 40 * amplitude / np.sqrt((amplitude**2).sum() / 2)

    def sample(self, x: Doubles, y: Doubles) -> Doubles:
        gray = np.full(x.shape, 128.0)
        for amplitude, kx, ky, phase in zip(self._amplitude, self._kx, self._ky, self._phase, strict=True):
            gray += amplitude * np.cos(kx * x + ky * y + phase)
        return gray


@dataclass(frozen=True)
class Pair:
    """Two frames, the later one's true flow (rows, cols, 2), and where it came from inside the earlier one."""

    before: Bytes
    now: Bytes
    flow_px: Doubles
    inside: Bools

    @classmethod
    def of(cls, before: Doubles, now: Doubles, flow_px: Doubles, noise: float, seed: int) -> Pair:
        rng = np.random.default_rng(seed)
        frames = (frame + noise * rng.standard_normal(frame.shape) for frame in (before, now))
        before_gray, now_gray = (np.clip(np.rint(frame), 0, 255).astype(np.uint8) for frame in frames)
        rows, cols = now.shape
        x, y = np.arange(cols) - flow_px[..., 0], np.arange(rows)[:, None] - flow_px[..., 1]
        inside = (x >= 0) & (x <= cols - 1) & (y >= 0) & (y <= rows - 1)
        return cls(before_gray, now_gray, flow_px, inside)

    def made(self, stage: Stage) -> Any:
        """Return the output that ``stage`` makes of the two frames after a reset."""
        stage.reset(0)
        step = stage.step  # type: ignore[attr-defined]
        assert step(Image(pixels=self.before), Stamp(0)) is None
        return step(Image(pixels=self.now), Stamp(INTERVAL_US))

    def estimate(self, stage: Stage) -> Flow:
        """Return the flow that ``stage`` makes of the two frames after a reset."""
        made = self.made(stage)
        flow = getattr(made, "flow", made)
        assert isinstance(flow, Flow)
        return flow

    def error_px(self, flow: Flow) -> Doubles:
        """Return the length of the error of each vector, (rows, cols)."""
        error: Doubles = np.linalg.norm(flow.uv_px - self.flow_px, axis=-1)
        return error


def warped_pair(came_from: Warp, shape: tuple[int, int] = (120, 160), noise: float = 0.0, seed: int = 0) -> Pair:
    """Return the pair in which the pixel (x, y) of the later frame was at ``came_from(x, y)`` in the earlier one."""
    rows, cols = shape
    y, x = np.mgrid[:rows, :cols].astype(float)
    source_x, source_y = came_from(x, y)
    pattern = Pattern(seed)
    flow_px = np.stack([x - source_x, y - source_y], axis=-1)
    return Pair.of(pattern.sample(x, y), pattern.sample(source_x, source_y), flow_px, noise, seed)


class Drive:
    """A camera 1 m above a floor, 75 degrees down, 70 degrees wide, 160x120, beside a wall 0.35 m high.

    W is the earlier robot's frame; z up. The wall stands on the floor line ``normal . (x, y) = distance_m``.
    """

    ROWS, COLS = 120, 160
    FOCAL_PX = COLS / 2 / math.tan(math.radians(35))
    TILT_RAD = math.radians(75)
    HEIGHT_M, WALL_M = 1.0, 0.35

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        self._floor, self._wall = Pattern(seed, shortest=8.0), Pattern(seed + 1, shortest=8.0)
        bearing = rng.uniform(-1.0, 1.0) + math.pi / 2 * rng.choice([-1, 1])
        self._normal = np.array([math.cos(bearing), math.sin(bearing)])
        self._distance_m = rng.uniform(0.2, 0.5)

    def pair(self, forward_m: float, turn_rad: float, noise: float, seed: int) -> Pair:
        """Return the frames before and after a move along an arc."""
        half = turn_rad / 2
        chord_m = forward_m * math.sin(half) / half if half else forward_m
        then = (0.0, 0.0, 0.0)
        now = (chord_m * math.cos(half), chord_m * math.sin(half), turn_rad)
        before, _ = self._look(then)
        after, points = self._look(now)
        rotation, position = self._pose(then)
        in_camera = (points - position) @ rotation
        came_from = in_camera[..., :2] / in_camera[..., 2:] * self.FOCAL_PX + self._centre()
        y, x = np.mgrid[: self.ROWS, : self.COLS]
        return Pair.of(before, after, np.stack([x, y], axis=-1) - came_from, noise, seed)

    def _centre(self) -> Doubles:
        return np.array([self.COLS - 1, self.ROWS - 1]) / 2

    def _pose(self, pose: tuple[float, float, float]) -> tuple[Doubles, Doubles]:
        x, y, yaw = pose
        c, s = math.cos(self.TILT_RAD), math.sin(self.TILT_RAD)
        to_robot = np.array([[0, -s, c], [-1, 0, 0], [0, -c, -s]])
        turn = np.array([[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]])
        return turn @ to_robot, np.array([x, y, self.HEIGHT_M])

    def _look(self, pose: tuple[float, float, float]) -> tuple[Doubles, Doubles]:
        """Return the picture and the point that each pixel sees, (rows, cols, 3)."""
        rotation, position = self._pose(pose)
        y, x = np.mgrid[: self.ROWS, : self.COLS]
        in_camera = np.concatenate(
            [(np.stack([x, y], axis=-1) - self._centre()) / self.FOCAL_PX, np.ones((*x.shape, 1))], -1
        )
        rays = in_camera @ rotation.T
        to_floor = -position[2] / rays[..., 2]
        to_wall = (self._distance_m - position[:2] @ self._normal) / (rays[..., :2] @ self._normal)
        height = position[2] + to_wall * rays[..., 2]
        on_wall = (to_wall > 0) & (to_wall < to_floor) & (height <= self.WALL_M)
        points = position + np.where(on_wall, to_wall, to_floor)[..., None] * rays
        along = points[..., :2] @ np.array([-self._normal[1], self._normal[0]])
        scale = self.FOCAL_PX / self.HEIGHT_M
        floor = self._floor.sample(points[..., 0] * scale, points[..., 1] * scale)
        wall = self._wall.sample(along * scale, points[..., 2] * scale)
        return np.where(on_wall, wall, floor), points


def driven_pairs(turn_radps: float, count: int, *, noise: float = 2.0) -> list[Pair]:
    """Return one pair of frames each of ``count`` drives at 0.3 m/s, 10 Hz."""
    return [Drive(seed).pair(0.03, turn_radps / 10 * (-1) ** seed, noise, seed) for seed in range(count)]


@pytest.fixture(name="warped_pair")
def _warped_pair() -> Callable[..., Pair]:
    return warped_pair


@pytest.fixture(name="driven_pairs", scope="session")
def _driven_pairs() -> Callable[..., list[Pair]]:
    return driven_pairs
