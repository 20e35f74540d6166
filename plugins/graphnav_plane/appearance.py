"""Dominant plane by brightness and texture of the picture: the baseline that ignores the flow."""

from __future__ import annotations

from typing import ClassVar

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import Continuity, Image, Plane, Role, Stage, Stamp, param
from graphnav.arrays import Floats, Indices

_MIN_GRAY = 1.0
"""Of the standard deviation of brightness, and of the texture's gradient per pixel: the steps of an 8-bit image."""
_MIN_SPREAD = 0.05


class Appearance(Stage):
    """Baseline: obstacle is what looks different from the floor before the robot, in a single picture.

    Of the pixels around each cell three numbers are taken: mean brightness, the logarithm of the mean squared gradient
    (how much texture), and how far the gradients have one direction (texture that is seen at an angle is foreshortened,
    0 to 1). The floor's values are a running mean and variance over the lower middle of the picture. The score is the
    root of the summed squares of the deviations, each in the floor's standard deviations.

    It sees no motion and no depth: where it arrives, the obstacles of the world are painted differently from its floor.
    """

    role: ClassVar[Role] = "baseline"

    cell_px: int = param(4, ge=1, le=4096, doc="side of the pixel blocks that become one cell")
    threshold: float = param(
        4.0,
        gt=0.0,
        le=1e6,
        doc="dimensionless: deviation from the floor, in standard deviations, above which a cell is obstacle",
    )
    window_ratio: float = param(
        0.11,
        gt=0.0,
        le=1.0,
        doc="side of the square around each cell over which brightness and texture are averaged, as a share of the "
        "picture's width",
    )
    memory_ratio: float = param(
        0.7, ge=0.0, lt=1.0, doc="weight of the last frames in what the floor looks like; 0 takes every frame alone"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002
        """Forget what the floor looks like."""
        self._floor: tuple[Floats, Floats] | None = None
        self._continuity = Continuity()

    def step(self, image: Image, stamp: Stamp) -> Plane:
        """Return the plane on cells of ``cell_px`` (of the image's own step, if that is coarser); all are judged."""
        if self._continuity.breaks(stamp):
            self._floor = None
        pixels = image.pixels if image.pixels.ndim == 2 else cv2.cvtColor(image.pixels, cv2.COLOR_RGB2GRAY)
        factor = max(1, self.cell_px // image.step_px)
        window = max(1, round(self.window_ratio * pixels.shape[1]))
        seen = looks(pixels.astype(np.float32), window)[np.ix_(*(_middles(size, factor) for size in pixels.shape))]
        mean, variance = self._learned(seen)
        spread = np.maximum(np.sqrt(variance), np.array([_MIN_GRAY, _MIN_SPREAD, _MIN_SPREAD], np.float32))
        deviation = (seen - mean) / spread
        score: Floats = np.sqrt(np.einsum("rck,rck->rc", deviation, deviation))
        obstacle = (score > self.threshold).astype(np.uint8)
        return Plane(
            obstacle=obstacle,
            score=score,
            valid=np.ones_like(obstacle),
            step_px=factor * image.step_px,
            obstacle_ratio=float(obstacle.mean()),
            threshold=self.threshold,
        )

    def _learned(self, seen: Floats) -> tuple[Floats, Floats]:
        """Return mean and variance of what the floor shows, (3,) each, this frame included."""
        rows, cols = seen.shape[:2]
        floor = seen[2 * rows // 5 :, cols // 4 : max(cols - cols // 4, 1)].reshape(-1, 3)
        now = floor.mean(axis=0), floor.var(axis=0)
        share = np.float32(0.0 if self._floor is None else self.memory_ratio)
        before = self._floor or now
        self._floor = (share * before[0] + (1 - share) * now[0], share * before[1] + (1 - share) * now[1])
        return self._floor


def _middles(size: int, factor: int) -> Indices:
    """Return the middle pixel of every block of ``factor`` of ``size`` pixels; the last block may be cut."""
    return np.minimum(np.arange(0, size, factor) + factor // 2, size - 1)


def looks(gray: Floats, window: int) -> Floats:
    """Return brightness (gray levels), texture (logarithm) and its direction (0 to 1) around pixels, (rows, cols, 3).

    ``gray``: (rows, cols). ``window``: side, px, of the square over which they are averaged, mirrored at the border.
    """

    def averaged(field: Floats) -> npt.NDArray[np.float32]:
        return np.asarray(cv2.blur(field, (window, window), borderType=cv2.BORDER_REFLECT), np.float32)

    right, down = (cv2.Sobel(gray, cv2.CV_32F, *axes, ksize=3, scale=1 / 8) for axes in ((1, 0), (0, 1)))
    uu, uv, vv = averaged(right * right), averaged(right * down), averaged(down * down)
    texture = uu + vv + np.float32(_MIN_GRAY)
    return np.dstack([averaged(gray), np.log(texture), cv2.magnitude(uu - vv, 2 * uv) / texture])
