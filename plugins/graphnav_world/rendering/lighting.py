"""Light that is not uniform: a lamp on the mast, its reflection, and shadows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Floats
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.camera import Camera
from graphnav_world.rendering.placed_faces import Placed
from graphnav_world.rendering.shadows import Shadows
from graphnav_world.rendering.visibility import Visible

WHITE_GRAY = 255.0
GLOSS = 150.0
"""Blinn's exponent: the reflection of a lamp on a floor of semi-gloss varnish is half as bright 5.5 degrees off."""


@dataclass(frozen=True)
class Lights:
    """Shares of light, dimensionless: the lamp's of all, the brightness of its reflection, the depth of shadows."""

    lamp: float = 0.0
    glare: float = 0.0
    shadow: float = 0.0

    def __bool__(self) -> bool:
        """Whether light differs from pixel to pixel."""
        return bool(self.lamp or self.glare or self.shadow)


class Lighting:
    """Lights the pixels of a picture by the surface points that they show; nothing above the horizon.

    The lamp sits at the camera's centre and shines along its optical axis, so that it casts no shadow that the camera
    sees. A Lambertian emitter lights a matt surface by cos(angle off the axis) cos(angle of incidence) / distance**2,
    scaled to a mean of one over an empty floor. The rest of the light is the uniform one of a world without a lamp, and
    shadows weaken only that, on surfaces that face the sun. The lamp's reflection is a power of the cosine of the angle
    between the normal and the direction halfway between lamp and camera [JB], here that of the line of sight: it is
    seen where a surface is square to that, on the floor at the foot of the mast, which is in the picture if the camera
    is tilted far enough.

    References
    ----------
    .. [JB] J. F. Blinn, Models of Light Reflection for Computer Synthesized Pictures, SIGGRAPH 1977.
    """

    def __init__(self, camera: Camera, faces: Faces, lights: Lights, shadows: Shadows | None) -> None:
        self._faces, self._lights, self._shadows = faces, lights, shadows
        self._rays: Floats = camera.rays().astype(np.float32)
        self._cos_axis = np.reciprocal(np.linalg.norm(self._rays, axis=-1))
        self._height_m = camera.height_m
        down = self._rays @ -camera.R_RC[2].astype(np.float32)
        floor = _lamp(
            np.maximum(down, 0.0) / np.float32(camera.height_m), np.full_like(down, camera.height_m), self._cos_axis
        )
        self._per_lamp = 1 / float(floor[down > 0].mean())

    def apply(self, gray: Floats, now: Placed, seen: Visible, inverse_depth: Floats, first_row: int = 0) -> None:
        """Light gray values in place, float32 (rows, cols): of all of the picture, or of rows from a first one on."""
        rows = slice(first_row, first_row + len(gray))
        distance_m, shade = np.full(gray.shape, now.eye_W[2], np.float32), np.ones(gray.shape, np.float32)
        face = seen.pixel_face
        distance_m.reshape(-1)[seen.pixel] = now.face_distance_m.take(face)
        shade.reshape(-1)[seen.pixel] = self._faces.shade.take(face)
        factor: Floats = np.full(gray.shape, 1 - self._lights.lamp, np.float32)
        if self._shadows is not None:
            factor *= 1 - self._lights.shadow * self._shadows.at(now, seen, self._rays[rows], inverse_depth)
        if self._lights.lamp:
            factor += (
                self._lights.lamp * self._per_lamp * _lamp(inverse_depth, distance_m, self._cos_axis[rows]) / shade
            )
        lit = inverse_depth > 0
        factor[~lit] = 1.0
        gray *= factor
        if self._lights.glare:
            gray += lit * self._glare(inverse_depth, distance_m, self._cos_axis[rows])

    def _glare(self, inverse_depth: Floats, distance_m: Floats, cos_axis: Floats) -> Floats:
        """Return the gray values of the lamp's reflection."""
        inverse_m = inverse_depth * cos_axis
        square = np.minimum(distance_m * inverse_m, 1.0) ** GLOSS
        glare: Floats = self._lights.glare * WHITE_GRAY * square * np.square(self._height_m * inverse_m)
        return glare


def _lamp(inverse_depth: Floats, distance_m: Floats, cos_axis: Floats) -> Floats:
    """Return the lamp's irradiance, 1/m**2; ``distance_m``: of the planes that pixels show, (rows, cols)."""
    inverse_m = inverse_depth * cos_axis
    light: Floats = cos_axis * distance_m * inverse_m**3
    return light
