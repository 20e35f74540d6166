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

    ``camera``: its mounting at this time. ``heading``: cosine and sine of the robot's yaw. ``moving``: body and its
    position (x, y, z) in W, for the moving ones.
    """

    faces: Faces
    camera: Camera
    eye_W: Doubles  # noqa: N815  # the frame's letter
    R_WC: Doubles
    heading: tuple[float, float]
    moving: tuple[tuple[int, Doubles], ...]

    @classmethod
    def at(cls, camera: Camera, faces: Faces, x_m: float, y_m: float, yaw_rad: float, time_s: float = 0.0) -> Placed:
        """Return the faces relative to the camera of a robot at this pose and time."""
        R_WC, eye = camera.pose(x_m, y_m, yaw_rad)
        moving = tuple(
            (body, np.array([*mover.at(time_s), 0.0])) for body, mover in zip(faces.moving, faces.movers, strict=True)
        )
        return cls(faces, camera, eye, R_WC, (math.cos(yaw_rad), math.sin(yaw_rad)), moving)

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

    def edge_planes(self, prims: Indices) -> Doubles:
        """Return the normals in C of the planes through the eye and each edge of prims (ascending), (3, 4, n).

        They point to the inside of a prim that faces the camera.
        """
        edges = self.faces.prims.edges.take(prims, axis=2)
        planes = (self._C_from_line(self.eye_W) @ edges.reshape(6, -1)).reshape(3, 4, -1)
        for (_, position), of_body in zip(self.moving, self.faces.prims.of_moving, strict=True):
            part = slice(*np.searchsorted(prims, (of_body.start, of_body.stop)))
            matrix = self._C_from_line(self.eye_W - position)
            planes[..., part] = (matrix @ edges[..., part].reshape(6, -1)).reshape(3, 4, -1)
        return planes

    def _C_from_line(self, eye: Doubles) -> Doubles:  # noqa: N802  # the frame's letter
        """Return the matrix (3, 6) that takes a line to the normal in C of the plane through it and an eye."""
        x, y, z = eye.tolist()
        matrix = np.empty((3, 6))
        np.matmul(self.R_WC.T, [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]], out=matrix[:, :3])
        matrix[:, 3:] = self.R_WC.T
        return matrix

    def affine(self, functions: Doubles, face: Indices) -> tuple[Doubles, Doubles]:
        """Return functions of the point on these faces, relative to the eye in C: slopes (3, k, n), offsets (k, n).

        ``functions``: of all faces, of the point in W (of moving bodies: in their own frame), (4, k, faces).
        """
        functions = functions.take(face, axis=2)
        shape = functions.shape
        offset = (self.eye_W @ functions[:3].reshape(3, -1)).reshape(shape[1:])
        offset += functions[3]
        for body, position in self.moving:
            of_body = np.flatnonzero(self.faces.body.take(face) == body)
            offset[:, of_body] -= np.tensordot(position, functions[:3].take(of_body, axis=2), 1)
        return (self.R_WC.T @ functions[:3].reshape(3, -1)).reshape(3, *shape[1:]), offset

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
