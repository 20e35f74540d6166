"""The gray values of a picture against a plain lookup of every pixel's surface point."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from graphnav_world.geometry.scene import Body, Faces
from graphnav_world.rendering.atlas import Atlas
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.mip import STRETCH
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.render import Renderer
from graphnav_world.rendering.textures import TEXEL_M

from graphnav.arrays import Doubles, Ints

Cast = Callable[[Camera, Placed, Faces], tuple[Ints, Doubles]]
ORIGIN_M = np.array([-2.5, -2.5])


@pytest.mark.parametrize(
    "camera", [Camera(cols=96, rows=72), Camera(cols=96, rows=72, height_m=0.7, tilt_deg=35.0)], ids=["down", "ahead"]
)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_every_pixel_shows_the_texture_of_its_point(
    camera: Camera, seed: int, world: Any, cast: Cast, random_bodies: Callable[[int], list[Body]]
) -> None:
    faces, renderer = world(camera, random_bodies(seed))
    placed = Placed.at(camera, faces, 0.1, 0.05, 0.4, time_s=0.7)
    frame = renderer.render(placed, None)
    face, depth = cast(camera, placed, faces)
    expected = _gray(camera, placed, faces, _atlas_of(renderer), face, depth)
    error = np.abs(frame.pixels - expected)[(frame.surface == face) & np.isfinite(depth)]
    assert error.mean() < 0.5, "rounding to a gray level is 0.25, to 1/32 of a texel the rest"
    assert (error > 2.0).mean() < 1e-3


def _atlas_of(renderer: Renderer) -> Atlas:
    return renderer._floor._atlas


def _gray(camera: Camera, placed: Placed, faces: Faces, atlas: Atlas, face: Ints, depth: Doubles) -> Doubles:
    """Return the gray value of every pixel, float64 (rows, cols), by a blend of two mip levels."""
    rays = camera.rays()
    points = placed.eye_W + (rays * depth[..., None]) @ placed.R_WC.T
    gray = np.full(depth.shape, np.nan)
    for row, col in np.argwhere(np.isfinite(depth)):
        one, point, far = int(face[row, col]), points[row, col], float(depth[row, col])
        (u, v), texture, shade, distance = point[:2] - ORIGIN_M, 0, 1.0, camera.height_m
        if one >= 0:
            local = point - dict(placed.moving).get(int(faces.body[one]), np.zeros(3))
            u, v = (axis[one, :3] @ local + axis[one, 3] for axis in (faces.u, faces.v))
            texture, shade = int(faces.texture[one]) + 1, float(faces.shade[one])
            distance = abs(float(faces.normal[one] @ (point - placed.eye_W)))
        wide_m = far / camera.focal_px
        long_m = wide_m * far * float(rays[row, col] @ rays[row, col]) / distance / STRETCH
        level = np.clip(np.log2(max(wide_m, long_m) / TEXEL_M), 0, atlas.levels - 1.001)
        fine, coarse = (_texel(atlas, texture, int(level) + k, u, v) for k in range(2))
        gray[row, col] = shade * (fine + (level - int(level)) * (coarse - fine))
    return gray.clip(0, 255)


def _texel(atlas: Atlas, texture: int, level: int, u: float, v: float) -> float:
    """Return a bilinear sample."""
    place = np.array([u, v]) % atlas.period_m[texture] / atlas.texel_m[level] + atlas.origin_px[texture, level]
    (x, y), (right, down) = np.floor(place).astype(int), place % 1
    cell = atlas.pixels[y : y + 2, x : x + 2].astype(float)
    return float(np.array([1 - down, down]) @ cell @ np.array([1 - right, right]))
