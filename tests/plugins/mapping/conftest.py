"""A camera over a floor with pillars, projected ray by ray and independently of the stages."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from graphnav import Flow, Plane
from graphnav.arrays import Bools, Doubles

ROWS, COLS = 120, 160


@dataclass(frozen=True)
class Camera:
    """A pinhole camera on a robot at a pose; ``pitch_rad`` (nose down) and ``roll_rad`` (left side up) are shakes."""

    x_m: float = 0.0
    y_m: float = 0.0
    yaw_rad: float = 0.0
    ahead_m: float = 0.0
    height_m: float = 1.0
    tilt_deg: float = 60.0
    fov_deg: float = 70.0
    pitch_rad: float = 0.0
    roll_rad: float = 0.0

    @property
    def middle(self) -> Doubles:
        """The centre of projection."""
        along = np.array([math.cos(self.yaw_rad), math.sin(self.yaw_rad)])
        return np.array([*(np.array([self.x_m, self.y_m]) + self.ahead_m * along), self.height_m])

    @property
    def axes(self) -> Doubles:
        """The directions right, down and along the optical axis of the camera, rows of (3, 3)."""
        tilt = math.radians(self.tilt_deg) + self.pitch_rad
        c, s = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        # Roll turns all axes about the horizontal direction ahead: z comes forward from left.
        level = [np.array([s, -c, 0.0]), np.array([-math.sin(tilt) * c, -math.sin(tilt) * s, -math.cos(tilt)])]
        level.append(np.array([math.cos(tilt) * c, math.cos(tilt) * s, -math.sin(tilt)]))
        ahead = np.array([c, s, 0.0])
        return np.array([_turned(axis, ahead, self.roll_rad) for axis in level])

    def focal_px(self) -> float:
        """Return the focal length of a picture of `COLS` columns."""
        return COLS / 2 / math.tan(math.radians(self.fov_deg) / 2)

    def rays(self) -> Doubles:
        """Return the direction of each pixel's line of sight, (ROWS, COLS, 3)."""
        u, v = np.meshgrid(np.arange(COLS) - (COLS - 1) / 2, np.arange(ROWS) - (ROWS - 1) / 2)
        return np.dstack([u, v, np.full_like(u, self.focal_px())]) @ self.axes

    def floor_points(self) -> Doubles:
        """Return the floor point that each pixel sees, (ROWS, COLS, 3); all pixels must see the floor."""
        rays = self.rays()
        assert (rays[..., 2] < 0).all()
        return np.asarray(self.middle - rays * (self.height_m / rays[..., 2])[..., None])

    def project(self, points: Doubles) -> Doubles:
        """Return the pixels (column, row) of points (..., 3)."""
        seen = (points - self.middle) @ self.axes.T
        middle = np.array([(COLS - 1) / 2, (ROWS - 1) / 2])
        return np.asarray(middle + self.focal_px() * seen[..., :2] / seen[..., 2:])

    def driven(self, chord_m: float, turn_rad: float) -> Camera:
        """Return the camera after an arc with this chord and turn."""
        along = self.yaw_rad + turn_rad / 2
        return replace(
            self,
            x_m=self.x_m + chord_m * math.cos(along),
            y_m=self.y_m + chord_m * math.sin(along),
            yaw_rad=self.yaw_rad + turn_rad,
        )


@dataclass(frozen=True)
class Pillar:
    """An upright cylinder on the floor."""

    x_m: float
    y_m: float
    radius_m: float = 0.1
    height_m: float = 0.3

    def covers(self, camera: Camera) -> Bools:
        """Return which pixels show the pillar, (ROWS, COLS): their line of sight meets it above the floor."""
        rays, middle = camera.rays(), camera.middle
        away = middle[:2] - [self.x_m, self.y_m]
        a = (rays[..., :2] ** 2).sum(axis=-1)
        b = rays[..., :2] @ away
        root = b**2 - a * (away @ away - self.radius_m**2)
        with np.errstate(divide="ignore", invalid="ignore"):
            enter, leave = (-b - np.sqrt(root)) / a, (-b + np.sqrt(root)) / a
            lowest = middle[2] + rays[..., 2] * np.maximum(enter, 0.0)
            return np.asarray(
                (root > 0) & (leave > 0) & (lowest >= 0) & (middle[2] + rays[..., 2] * leave <= self.height_m)
            )


def floor_flow(before: Camera, now: Camera) -> Flow:
    """Return the exact flow of an empty floor between two frames."""
    points = now.floor_points()
    return Flow((now.project(points) - before.project(points)).astype(np.float32), _ones(1), 100_000)


def empty_plane(step_px: int = 4) -> Plane:
    """Return a plane that is all ground."""
    free = np.zeros((ROWS // step_px, COLS // step_px), np.uint8)
    return Plane(free, free.astype(np.float32), _ones(step_px), step_px, 0.0)


def seen_plane(camera: Camera, *pillars: Pillar) -> Plane:
    """Return the perfect dominant plane of a camera among pillars, one cell for each pixel."""
    obstacle = np.zeros((ROWS, COLS), np.uint8)
    for pillar in pillars:
        obstacle |= pillar.covers(camera).view(np.uint8)
    return Plane(obstacle, obstacle.astype(np.float32), _ones(1), 1, float(obstacle.mean()))


def _ones(step_px: int) -> np.ndarray:
    return np.ones((ROWS // step_px, COLS // step_px), np.uint8)


def _turned(vector: Doubles, about: Doubles, angle_rad: float) -> Doubles:
    """Return a vector turned about a unit vector, by Rodrigues' formula."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    return np.asarray(vector * c + np.cross(about, vector) * s + about * (about @ vector) * (1 - c))
