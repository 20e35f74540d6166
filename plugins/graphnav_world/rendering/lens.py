"""A lens that distorts, by OpenCV's model: where a pixel of its picture lies in that of a pinhole."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles, Floats, Ints
from graphnav_world.rendering.camera import Camera

NEWTON_STEPS = 20
MAX_PIXELS_RATIO = 4.0
"""Maximum size of the pinhole's picture, over that of the lens."""


@dataclass(frozen=True)
class Lens:
    """A lens of a camera: x = u (1 + k1 |u|**2 + k2 |u|**4), with u = (X / Z, Y / Z) of a point in C.

    ``camera``: what it would be without distortion; its focal length is that of both pictures.
    """

    camera: Camera
    k1: float
    k2: float

    @cached_property
    def fault(self) -> str | None:
        """Reason why it makes no picture, None if it does."""
        # the distorted radius rises up to the first zero of its derivative, 1 + 3 k1 r**2 + 5 k2 r**4
        end = self._monotonic_to()
        if self._distorted_radius(end) <= self._corner:
            seen = self._distorted_radius(end) * self.camera.focal_px
            return f"folds the picture back {seen:.0f} px from its centre, within its corners at {self._corner_px:.0f}"
        pixels = self.pinhole.cols * self.pinhole.rows
        if pixels > MAX_PIXELS_RATIO * self.camera.cols * self.camera.rows:
            return "shows more than a pinhole picture four times as large"
        return None

    @cached_property
    def pinhole(self) -> Camera:
        """The camera without distortion, with as many more or fewer columns and rows as the lens shows."""
        x, y = self._undistorted(self._border)
        cx, cy = self.camera.center_px
        margin_x, margin_y = (
            math.ceil(float(np.abs(u).max()) * self.camera.focal_px - half) + 1 for u, half in ((x, cx), (y, cy))
        )
        cols, rows = self.camera.cols + 2 * margin_x, self.camera.rows + 2 * margin_y
        fov_deg = 2 * math.degrees(math.atan(cols / 2 / self.camera.focal_px))
        return replace(self.camera, cols=cols, rows=rows, fov_deg=fov_deg)

    @cached_property
    def maps(self) -> tuple[Floats, Floats]:
        """Column and row in the pinhole's picture of every pixel, float32 (rows, cols) each."""
        rays = self.camera.rays()[..., :2]
        places = np.moveaxis(self._undistorted(np.moveaxis(rays, -1, 0)), 0, -1) * self.camera.focal_px
        places += self.pinhole.center_px
        x, y = np.moveaxis(places, -1, 0).astype(np.float32)
        return np.ascontiguousarray(x), np.ascontiguousarray(y)

    @property
    def corner_ratio(self) -> float:
        """How much farther off the axis the corners look than those of the camera without distortion."""
        return float(self._undistorted_radius(np.array(self._corner)) / self._corner)

    def window(self, rows: range) -> range:
        """Return the rows of the pinhole's picture that some rows show."""
        y = self.maps[1][rows.start : rows.stop]
        return range(math.floor(float(y.min())), min(math.floor(float(y.max())) + 2, self.pinhole.rows))

    def shown(self, gray: Floats, rows: range, window: range) -> Floats:
        """Return what some rows show of gray values of the window's rows of the pinhole's picture."""
        x, y = (one[rows.start : rows.stop] for one in self.maps)
        below = y - np.float32(window.start)
        shown: Floats = cv2.remap(gray, x, below, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return shown

    @cached_property
    def samples(self) -> Callable[[range, range], Samples]:
        """Where some rows sample a window of the pinhole's rows: a function of both, which keeps the last ones."""

        @lru_cache(maxsize=self.camera.rows)
        def samples(rows: range, window: range) -> Samples:
            x, y = (one[rows.start : rows.stop] for one in self.maps)
            return Samples(x, y, window.start, self.pinhole.cols)

        return samples

    def distorted_px(self, pinhole_px: Doubles) -> Doubles:
        """Return where the lens shows points of the pinhole's picture, (x, y), float64 (..., 2)."""
        u = (pinhole_px - self.pinhole.center_px) / self.camera.focal_px
        square = np.square(u).sum(axis=-1, keepdims=True)
        pixels: Doubles = u * (1 + square * (self.k1 + square * self.k2)) * self.camera.focal_px
        return pixels + self.camera.center_px

    @property
    def _border(self) -> Doubles:
        """X and y of the picture's border, (2, pixels)."""
        rays = self.camera.rays()
        edges = np.concatenate([rays[0], rays[-1], rays[:, 0], rays[:, -1]])
        return edges[:, :2].T

    @property
    def _corner(self) -> float:
        return self._corner_px / self.camera.focal_px

    @property
    def _corner_px(self) -> float:
        return math.hypot(*self.camera.center_px)

    def _distorted_radius(self, radius: float) -> float:
        if math.isinf(radius):
            return math.inf
        return radius * (1 + radius**2 * (self.k1 + radius**2 * self.k2))

    def _monotonic_to(self) -> float:
        """Return the radius up to which the distorted radius rises."""
        squares = np.roots([5 * self.k2, 3 * self.k1, 1.0])
        rising = [one.real for one in squares if abs(one.imag) < 1e-12 and one.real > 0]
        return math.sqrt(min(rising, default=math.inf))

    def _undistorted_radius(self, radius: Doubles) -> Doubles:
        """Return the radii of the pinhole's picture, by Newton's method from below or above, kept where it rises."""
        low, high = np.zeros_like(radius), np.full_like(radius, min(self._monotonic_to(), 1e6))
        found = np.minimum(radius, high)
        for _ in range(NEWTON_STEPS):
            square = found**2
            error = found * (1 + square * (self.k1 + square * self.k2)) - radius
            low, high = np.where(error < 0, found, low), np.where(error > 0, found, high)
            slope = 1 + square * (3 * self.k1 + square * 5 * self.k2)
            with np.errstate(divide="ignore", invalid="ignore"):
                following = found - error / slope
            inside = (following >= low) & (following <= high)
            found = np.where(inside, following, (low + high) / 2)
        return found

    def _undistorted(self, points: Doubles) -> Doubles:
        """Return points, x and y first, of the pinhole's picture at a depth of one."""
        radius = np.hypot(*points)
        ratio = np.ones_like(radius)
        np.divide(self._undistorted_radius(radius), radius, out=ratio, where=radius > 0)
        undistorted: Doubles = points * ratio
        return undistorted


class Samples:
    """Where the pixels of some rows lie in the pinhole's picture, and values between the four pixels around each.

    What shows one surface is interpolated; elsewhere the nearest pixel's value is taken. ``place``: x and y in all of
    the pinhole's picture, (rows, cols, 2).
    """

    def __init__(self, x: Floats, y: Floats, first_row: int, cols: int) -> None:
        left, above = np.floor(x), np.floor(y)
        self._right, self._down = x - left, y - above
        self._corner, self._cols = (above.astype(np.intp) - first_row) * cols + left.astype(np.intp), cols
        self._nearest = self._corner + (self._right > 0.5) + cols * (self._down > 0.5)
        self.place: Doubles = np.stack([x, y], axis=-1).astype(np.float64)

    def nearest(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Return the values of the nearest pixels; ``values``: (rows, cols)."""
        return values.take(self._nearest)

    def between(self, values: Sequence[Floats], surface: Ints) -> list[Floats]:
        """Return each of some values interpolated, all (rows, cols); ``surface``: which one each pixel shows."""
        alike = surface[1:] == surface[:-1]
        alike = alike[:, 1:] & alike[:, :-1] & (surface[1:, 1:] == surface[1:, :-1])
        differs = np.flatnonzero(~np.pad(alike, ((0, 1), (0, 1))).take(self._corner))
        nearest = self._nearest.reshape(-1).take(differs)
        found = []
        for one in values:
            corners = [one.take(self._corner + shift) for shift in (0, 1, self._cols, self._cols + 1)]
            upper, lower = (first + (second - first) * self._right for first, second in (corners[:2], corners[2:]))
            between = upper + (lower - upper) * self._down
            between.reshape(-1)[differs] = one.take(nearest)
            found.append(between)
        return found
