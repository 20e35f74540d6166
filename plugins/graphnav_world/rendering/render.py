"""The picture and the exact truth of a camera over a floor with upright bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from statistics import NormalDist

import cv2
import numpy as np

from graphnav.arrays import Bytes, Doubles, Floats, Ints
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.body_texture import BodyTexture
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.floor import Floor
from graphnav_world.rendering.lighting import Lighting
from graphnav_world.rendering.neutral import NeutralTexture
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.visibility import Visible, ZBuffer

FLOOR = -1
NOISE_BITS = 12
NOISE_STEPS = 2**NOISE_BITS
"""The values that noise has."""
_QUANTILES: Floats = np.array([NormalDist().inv_cdf((k + 0.5) / NOISE_STEPS) for k in range(NOISE_STEPS)], np.float32)
_MIN_DEPTH_RATIO = np.float32(1e-6)
"""Minimum of a point's former depth over the present one: flow stays finite."""


@dataclass(frozen=True)
class Frame:
    """A picture and its ground truth, which is computed where it is asked for.

    ``pixels``: uint8 (rows, cols), gray. ``seen``: what is seen of bodies. ``floor_inverse_depth``: float32 (rows,
    cols), as if there were none. ``flow``: takes inverse depth to flow, None for a first frame.
    """

    pixels: Bytes
    seen: Visible
    floor_inverse_depth: Floats
    flow: Callable[[Floats], Floats] | None

    @cached_property
    def inverse_depth(self) -> Floats:
        """Inverse of the depth along the optical axis, float32 (rows, cols), 1/m, 0 above the horizon."""
        return _inverse_depth(self.floor_inverse_depth, self.seen)

    @property
    def depth_m(self) -> Floats:
        """Depth along the optical axis, float32 (rows, cols), infinite above the horizon."""
        with np.errstate(divide="ignore"):
            return np.reciprocal(self.inverse_depth)

    @property
    def flow_px(self) -> Floats | None:
        """Displacement of every pixel's surface point, right and down, float32 (rows, cols, 2); None at first."""
        return None if self.flow is None else self.flow(self.inverse_depth)

    @property
    def obstacle(self) -> Bytes:
        """Where a body is seen: uint8 (rows, cols), 1 there."""
        obstacle = np.zeros(self.pixels.shape, np.uint8)
        obstacle.reshape(-1)[self.seen.pixel] = 1
        return obstacle

    @property
    def face(self) -> Ints:
        """Which face is seen: int32 (rows, cols), -1 for the floor and above the horizon."""
        face = np.full(self.pixels.shape, FLOOR, np.int32)
        face.reshape(-1)[self.seen.pixel] = self.seen.pixel_face
        return face


@dataclass(frozen=True)
class Film:
    """Brightness and noise, which ``rng`` draws: they make a picture of gray values."""

    light: float = 1.0
    noise_sigma_gray: float = 0.0
    rng: np.random.Generator | None = None

    def exposed(self, gray: Floats, views: int = 1) -> Bytes:
        """Return the picture, uint8, of the sum of the gray values of so many views."""
        noise, sigma = gray, 0.0
        if self.noise_sigma_gray and self.rng is not None:
            noise, sigma = normal_noise(gray.shape, self.rng), self.noise_sigma_gray
        pixels: Bytes = cv2.addWeighted(gray, self.light / views, noise, sigma, 0.0, dtype=cv2.CV_8U)
        return pixels


class Renderer:
    """Renders one world.

    ``floor_origin_m``: the world point where the floor's texture begins. ``lighting``: None for uniform light.
    ``neutral``: draws all surfaces in place of their textures. Everything is computed from the same exact hits of pixel
    rays and planes: texture coordinates, depth and flow.
    """

    def __init__(
        self,
        camera: Camera,
        faces: Faces,
        atlas: Atlas,
        floor_origin_m: Doubles,
        *,
        lighting: Lighting | None = None,
        neutral: NeutralTexture | None = None,
    ) -> None:
        self._zbuffer = ZBuffer(camera)
        self._floor = Floor(camera, atlas, floor_origin_m)
        self._texture = BodyTexture(camera, faces, atlas)
        self._flow = TrueFlow(camera, faces)
        self._lighting, self._neutral = lighting, neutral

    def render(
        self,
        now: Placed,
        before: Placed | None,
        *,
        meanwhile: Sequence[Placed] = (),
        film: Film | None = None,
    ) -> Frame:
        """Return the frame seen from ``now``, with the flow since ``before``.

        ``meanwhile``: other camera poses while the shutter was open; the picture is the mean of all, the rest is of
        ``now`` alone.
        """
        seen = self._zbuffer.find(now)
        gray = self._gray(now, seen)
        for moment in meanwhile:
            gray += self._gray(moment, self._zbuffer.find(moment))
        pixels = (film or Film()).exposed(gray, 1 + len(meanwhile))
        flow = None if before is None else partial(self._flow.between, now, before, seen)
        return Frame(pixels, seen, self._floor.inverse_depth(now), flow)

    def _gray(self, placed: Placed, seen: Visible) -> Floats:
        """Return the gray values before brightness and noise, float32 (rows, cols)."""
        gray = self._floor.gray(placed) if self._neutral is None else self._neutral.gray(placed)
        if len(seen.pixel) and self._neutral is None:
            gray.reshape(-1)[seen.pixel] = self._texture.gray(placed, seen)
        if self._lighting is not None:
            self._lighting.apply(gray, placed, seen, _inverse_depth(self._floor.inverse_depth(placed), seen))
        return gray


def _inverse_depth(of_floor: Floats, seen: Visible) -> Floats:
    inverse = of_floor.copy()
    inverse.reshape(-1)[seen.pixel] = seen.inverse_depth
    return inverse


def normal_noise(shape: tuple[int, ...], rng: np.random.Generator) -> Floats:
    """Return Gaussian noise of sigma 1, float32, cut to 4096 quantiles: a tenth of the cost of exact draws.

    Each value takes the high bits of 16 random ones.
    """
    size = math.prod(shape)
    if size % 4 == 0:
        words = rng.bit_generator.random_raw(size // 4)
    else:  # the same bits, from words of which none is drawn in part
        words = rng.integers(0xFFFFFFFF, size=(size + 1) // 2, dtype=np.uint32, endpoint=True)
    draws = words.view(np.uint16)[:size] >> (16 - NOISE_BITS)
    return _QUANTILES.take(draws.astype(np.intp)).reshape(shape)


class TrueFlow:
    """Computes flow from inverse depth, of which a point's former position is a linear function at each pixel."""

    def __init__(self, camera: Camera, faces: Faces) -> None:
        self._focal_px, self._faces = np.float32(camera.focal_px), faces
        rays = camera.rays().astype(np.float32)
        self._x, self._y = rays[0, :, 0], rays[:, :1, 1]
        self._from_center_x, self._from_center_y = (self._focal_px * one for one in (self._x, self._y))

    def between(self, now: Placed, before: Placed, seen: Visible, inverse_depth: Floats) -> Floats:
        """Return the displacement of every pixel's surface point since ``before``, float32 (rows, cols, 2)."""
        matrix = before.camera_from(now).astype(np.float32)
        past = [x * self._x + (y * self._y + one) for x, y, one, _ in matrix]
        for axis, shift in enumerate(matrix[:, 3]):
            past[axis] += inverse_depth * shift
        for body, moved_W in now.moved_since(before):
            of_body = np.flatnonzero(self._faces.body.take(seen.pixel_face) == body)
            at, inverse = seen.pixel.take(of_body), seen.inverse_depth.take(of_body)
            for axis, moved in enumerate((before.R_WC.T @ moved_W).astype(np.float32)):
                past[axis].reshape(-1)[at] -= inverse * moved
        per_depth = self._focal_px / np.maximum(past[2], _MIN_DEPTH_RATIO, out=past[2])
        for axis, from_center in enumerate((self._from_center_x, self._from_center_y)):
            past[axis] *= per_depth
            np.subtract(from_center, past[axis], out=past[axis])
        flow: Floats = cv2.merge(past[:2])
        return flow
