"""Surfaces whose appearance says nothing: one noise in all of the picture that moves with them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Doubles, Floats, Indices
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.floor import SKY_GRAY
from graphnav_world.rendering.hashed_points import LAYERS, Points, parents, points_of, tiles_at
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.textures import Texture
from graphnav_world.rendering.visibility import ZBuffer

FINEST_RAD, MIN_FINEST_PX = 0.0105, 1.0
"""Blur of the finest spots, as a share of the focal length: 1.2 px at 160 columns and 70 degrees."""
SCALES = 2
"""Sizes of spots, each twice as large as the one before, of equal variance. Larger ones reach farther over the edges of
bodies, where they move with one side only."""
SPOTS = 0.18
"""Number of spots within a square as wide as their blur."""
MARGIN_SIGMAS = 3
SAMPLE_PX = 2
"""Every so many rows and columns it is looked up which tiles of points are in view: a tile is far larger."""
FARTHEST_M = 1000.0


class _Seen(NamedTuple):
    """Surfaces in view of the padded picture, flat: index of the plane (0: floor, k + 1: face k), and 1/m."""

    plane: Indices
    inverse_depth: Doubles


class NeutralTexture:
    """Draws all surfaces as spots of one size and number per pixel, whatever their distance and slant.

    Spot noise (J. J. van Wijk, Spot noise, texture synthesis for data visualization, 1991). Spots are fixed to random
    points of floor and faces, and move with them, but are round and of one size in the picture. Of a surface's points,
    as many are shown as fill the picture at a constant density (their number per square metre times square metres
    per pixel), so that what is shown of any surface from anywhere is a Poisson process of the same density: a single
    picture is the same stationary noise, independent of what is in it. Its motion is not. A spot fades in and out
    where a surface comes nearer and goes away (as in P. Benard et al., Dynamic solid textures for real-time coherent
    stylization, 2009), and ends where its point is hidden.
    """

    def __init__(self, camera: Camera, faces: Faces, texture: Texture, seed: int) -> None:
        self._texture, self._faces = texture, faces
        finest_px = max(FINEST_RAD * camera.focal_px, MIN_FINEST_PX)
        self._sigmas_px = [finest_px * 2**scale for scale in range(SCALES)]
        self._salts = np.random.default_rng([seed, 14]).integers(1 << 62, size=SCALES).tolist()
        self._margin = math.ceil(MARGIN_SIGMAS * self._sigmas_px[-1])
        self._camera = _padded(camera, self._margin)
        self._zbuffer = ZBuffer(self._camera)
        self._rays = self._camera.rays()
        faces_u, faces_v = (axis[:, :3] for axis in (faces.u, faces.v))
        starts = faces.normal * faces.offset[:, None] - faces_u * faces.u[:, 3:] - faces_v * faces.v[:, 3:]
        self._start_W = np.concatenate([np.zeros((1, 3)), starts])
        self._u = np.concatenate([[[1.0, 0.0, 0.0]], faces_u])
        self._v = np.concatenate([[[0.0, 1.0, 0.0]], faces_v])

    def gray(self, now: Placed, rows: range | None = None) -> Floats:
        """Return the gray values before brightness and noise, float32 (rows, cols), of some rows or of all."""
        seen = self._seen(now)
        start_W, distance_m = self._planes(now)
        generations = [self._tiles(now, seen, start_W, distance_m)]
        while len(generations) < SCALES + LAYERS - 1:
            generations.append(parents(generations[-1]))
        total = np.zeros(self._rays.shape[:2], np.float32)
        for scale, (sigma_px, salt) in enumerate(zip(self._sigmas_px, self._salts, strict=True)):
            tiles = np.unique(np.concatenate(generations[scale : scale + LAYERS]))
            total += self._spots(points_of(tiles, salt), sigma_px, now, seen, start_W, distance_m)
        total *= np.float32(self._texture.contrast / math.sqrt(SCALES))
        total += np.float32(self._texture.mean)
        total[(seen.inverse_depth <= 0).reshape(total.shape)] = SKY_GRAY
        inner = slice(self._margin, -self._margin)
        picture = total[inner, inner] if rows is None else total[inner, inner][rows.start : rows.stop]
        return picture.copy()

    def _seen(self, now: Placed) -> _Seen:
        inverse = np.maximum(self._rays.reshape(-1, 3) @ -now.R_WC[2] / now.eye_W[2], 0.0)
        plane = np.zeros(len(inverse), np.intp)
        bodies = self._zbuffer.find(now)
        plane[bodies.pixel] = bodies.pixel_face + 1
        inverse[bodies.pixel] = bodies.inverse_depth
        return _Seen(plane, inverse)

    def _planes(self, now: Placed) -> tuple[Doubles, Doubles]:
        """Return where each plane's texture begins, relative to the eye in W, (planes, 3), and its distance."""
        start_W = self._start_W - now.eye_W
        for (_, position), of_body in zip(now.moving, self._faces.of_moving, strict=True):
            start_W[of_body.start + 1 : of_body.stop + 1] += position
        return start_W, np.concatenate([now.eye_W[2:], now.face_distance_m])

    def _tiles(self, now: Placed, seen: _Seen, start_W: Doubles, distance_m: Doubles) -> Indices:
        """Return the tiles of points that are in view of the finest spots."""
        sampled = np.arange(len(seen.plane)).reshape(self._rays.shape[:2])[::SAMPLE_PX, ::SAMPLE_PX].reshape(-1)
        sampled = sampled[seen.inverse_depth.take(sampled) > 1 / FARTHEST_M]
        plane, inverse = seen.plane.take(sampled), seen.inverse_depth.take(sampled)
        points = (self._rays.reshape(-1, 3).take(sampled, axis=0) / inverse[:, None]) @ now.R_WC.T
        points -= start_W.take(plane, axis=0)
        place_m = np.stack([(points * axis.take(plane, axis=0)).sum(axis=1) for axis in (self._u, self._v)])
        return tiles_at(plane, place_m, self._density(distance_m.take(plane), inverse, self._sigmas_px[0]))

    def _density(self, distance_m: Doubles, inverse_depth: Doubles, sigma_px: float) -> Doubles:
        """Return the number of spots per square metre that is constant in the picture."""
        px2_per_m2 = self._camera.focal_px**2 * distance_m * inverse_depth**3
        density: Doubles = SPOTS / sigma_px**2 * px2_per_m2
        return density

    def _spots(
        self, points: Points, sigma_px: float, now: Placed, seen: _Seen, start_W: Doubles, distance_m: Doubles
    ) -> Floats:
        """Return noise of standard deviation 1 in the padded picture, float32."""
        places = start_W.take(points.plane, axis=0)
        for axis, place_m in zip((self._u, self._v), points.place_m, strict=True):
            places += axis.take(points.plane, axis=0) * place_m[:, None]
        places = places @ now.R_WC
        ahead = np.flatnonzero(places[:, 2] > 1 / FARTHEST_M)
        x, y = self._camera.project(places.take(ahead, axis=0)).T
        rows, cols = self._rays.shape[:2]
        inside = np.flatnonzero((x > 0) & (x < cols - 1) & (y > 0) & (y < rows - 1))
        x, y, shown = x[inside], y[inside], ahead[inside]
        plane = points.plane.take(shown)
        visible = seen.plane.take(np.rint(y).astype(np.intp) * cols + np.rint(x).astype(np.intp)) == plane
        x, y, shown, plane = x[visible], y[visible], shown[visible], plane[visible]
        density = self._density(distance_m.take(plane), 1 / places[shown, 2], sigma_px)
        weight = points.sign.take(shown) * np.clip(2 - 2 * points.rank.take(shown) / density, 0.0, 1.0)
        return _blurred(x, y, weight, sigma_px, (rows, cols))


def _blurred(x: Doubles, y: Doubles, weight: Doubles, sigma_px: float, shape: tuple[int, int]) -> Floats:
    """Return spots of these weights, whose squares are 2/3 in the mean, as noise of standard deviation 1."""
    col, row = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    right, down = x - col, y - row
    corners = (
        (0, 0, (1 - right) * (1 - down)),
        (0, 1, right * (1 - down)),
        (1, 0, (1 - right) * down),
        (1, 1, right * down),
    )
    total = np.zeros(shape[0] * shape[1])
    for below, beside, share in corners:
        total += np.bincount((row + below) * shape[1] + col + beside, weight * share, minlength=total.size)
    blurred: Floats = cv2.GaussianBlur(
        total.reshape(shape).astype(np.float32), (0, 0), sigma_px, borderType=cv2.BORDER_CONSTANT
    )
    variance = SPOTS / sigma_px**2 * (2 / 3) / (4 * math.pi * (sigma_px**2 + 1 / 6))
    blurred /= np.float32(math.sqrt(variance))
    return blurred


def _padded(camera: Camera, margin: int) -> Camera:
    """Return the camera with more rows and columns on all sides."""
    cols, rows = camera.cols + 2 * margin, camera.rows + 2 * margin
    fov_deg = 2 * math.degrees(math.atan(cols / 2 / camera.focal_px))
    return replace(camera, cols=cols, rows=rows, fov_deg=fov_deg)
