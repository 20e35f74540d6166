"""The faces of a world relative to the camera at one time."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from graphnav.arrays import Doubles, Indices
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.camera import Camera


@dataclass(frozen=True)
class Placed:
    """The camera in W, and the world's faces.

    ``heading``: cosine and sine of the robot's yaw. ``moving``: body and its position (x, y, z) in W, for the moving
    ones.
    """

    faces: Faces
    eye_W: Doubles  # noqa: N815  # the frame's letter
    R_WC: Doubles
    heading: tuple[float, float]
    moving: tuple[tuple[int, Doubles], ...]

    @classmethod
    def at(cls, camera: Camera, faces: Faces, x_m: float, y_m: float, yaw_rad: float, time_s: float = 0.0) -> Placed:
        """Return the faces relative to the camera of a robot at this pose and time."""
        R_WC, eye = camera.pose(x_m, y_m, yaw_rad)
        moving = tuple(
            (body, np.array([*patrol.at(time_s), 0.0]))
            for body, patrol in zip(faces.moving, faces.patrols, strict=True)
        )
        return cls(faces, eye, R_WC, (math.cos(yaw_rad), math.sin(yaw_rad)), moving)

    @cached_property
    def face_distance_m(self) -> Doubles:
        """Of the eye before each face's plane, float64 (faces,); only faces with a positive one face the camera."""
        distance: Doubles = self.faces.normal @ self.eye_W - self.faces.offset
        for (_, position), of_body in zip(self.moving, self.faces.of_moving, strict=True):
            distance[of_body] -= self.faces.normal[of_body] @ position
        return distance

    def heights(self, planes_C: Doubles) -> Doubles:
        """Return how far inside of planes through the eye each prim's center is, float64 (planes, prims).

        ``planes_C``: unit normals in C, (planes, 3).
        """
        planes_W = planes_C @ self.R_WC.T
        height: Doubles = planes_W @ self.faces.prims.center
        height -= (planes_W @ self.eye_W)[:, None]
        for (_, position), of_body in zip(self.moving, self.faces.prims.of_moving, strict=True):
            height[:, of_body] += (planes_W @ position)[:, None]
        return height

    def vertices(self, prims: Indices) -> Doubles:
        """Return the corners of prims (ascending) in C, (3, 4, n): x, y and z of each corner."""
        corners = self.faces.quads.take(prims, axis=0)
        corners -= self.eye_W
        for (_, position), of_body in zip(self.moving, self.faces.prims.of_moving, strict=True):
            corners[slice(*np.searchsorted(prims, (of_body.start, of_body.stop)))] += position
        return (corners.reshape(-1, 3) @ self.R_WC).reshape(-1, 4, 3).transpose(2, 1, 0).copy()

    def affine(self, functions: Doubles, face: Indices) -> tuple[Doubles, Doubles]:
        """Return functions of the point on these faces, relative to the eye in C: slopes (n, k, 3), offsets (n, k).

        ``functions``: of all faces, of the point in W (of moving bodies: in their own frame), (faces, k, 4).
        """
        functions = functions.take(face, axis=0)
        to_C_and_eye = np.empty((3, 4))
        to_C_and_eye[:, :3], to_C_and_eye[:, 3] = self.R_WC, self.eye_W
        slope_and_offset = (functions[..., :3].reshape(-1, 3) @ to_C_and_eye).reshape(functions.shape)
        slope, offset = slope_and_offset[..., :3], slope_and_offset[..., 3]
        offset += functions[..., 3]
        for body, position in self.moving:
            of_body = self.faces.body.take(face) == body
            offset[of_body] -= functions[of_body, :, :3] @ position
        return slope, offset

    def camera_from(self, other: Placed) -> Doubles:
        """Return the matrix (3, 4) that takes homogeneous points in the other's C to this one's."""
        moved = np.empty((3, 4))
        moved[:, :3] = self.R_WC.T @ other.R_WC
        moved[:, 3] = self.R_WC.T @ (other.eye_W - self.eye_W)
        return moved

    def moved_since(self, before: Placed) -> Iterator[tuple[int, Doubles]]:
        """Yield every moving body with its displacement (x, y, z) in W."""
        for (body, now), (_, then) in zip(self.moving, before.moving, strict=True):
            yield body, now - then
