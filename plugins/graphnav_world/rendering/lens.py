"""A lens that distorts, by OpenCV's model: where a pixel of its picture lies in that of a pinhole."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import cv2
import numpy as np

from graphnav.arrays import Bools, Doubles, Floats, Indices
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
        """What keeps it from making a picture, None if nothing does."""
        # the ratio of radii rises with the radius to 1 (barrel), or falls: its inverse exists up to the first zero of
        # the derivative of the distorted radius, 1 + 3 k1 r**2 + 5 k2 r**4
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
        shown: Floats = cv2.remap(
            gray, x, y - np.float32(window.start), cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        return shown

    def samples(self, surface: Indices, rows: range, window: range) -> Samples:
        """Return where some rows sample the window's rows; ``surface``: which one each of its pixels shows."""
        x, y = (one[rows.start : rows.stop] for one in self.maps)
        return Samples.of(x, y - np.float32(window.start), surface)

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


@dataclass(frozen=True)
class Samples:
    """Where the pixels of a picture sample another one: between the four pixels around, or at the nearest.

    ``x``, ``y``: place, (rows, cols). ``nearest``: flat index. ``corner``: flat index of the upper left one of the four.
    ``alike``: whether all four show the same surface, so that values between them are its own.
    """

    x: Doubles
    y: Doubles
    nearest: Indices
    corner: Indices
    alike: Bools
    cols: int

    @classmethod
    def of(cls, x: Floats, y: Floats, surface: Indices) -> Samples:
        """Return the samples of places in a picture of these surfaces."""
        rows, cols = surface.shape
        left, above = (np.clip(np.floor(one), 0, n - 2).astype(np.intp) for one, n in ((x, cols), (y, rows)))
        corner = above * cols + left
        near = [np.clip(np.rint(one), 0, n - 1).astype(np.intp) for one, n in ((x, cols), (y, rows))]
        of_corner = surface.take(corner)
        alike = np.ones(x.shape, bool)
        for shift in (1, cols, cols + 1):
            alike &= surface.take(corner + shift) == of_corner
        return cls(x.astype(np.float64), y.astype(np.float64), near[1] * cols + near[0], corner, alike, cols)

    def between(self, values: Floats) -> Doubles:
        """Return values, (rows, cols) or with more axes, interpolated within a surface, else those of the nearest."""
        flat = values.reshape(-1, *values.shape[2:]).astype(np.float64)
        right, down = self.x - self.corner % self.cols, self.y - self.corner // self.cols
        if flat.ndim > 1:
            right, down = right[..., None], down[..., None]
        upper = flat[self.corner] * (1 - right) + flat[self.corner + 1] * right
        lower = flat[self.corner + self.cols] * (1 - right) + flat[self.corner + self.cols + 1] * right
        alike = self.alike if flat.ndim == 1 else self.alike[..., None]
        between: Doubles = np.where(alike, upper * (1 - down) + lower * down, flat[self.nearest])
        return between
