"""The faces of a world relative to the camera at one time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from graphnav.arrays import Doubles, Floats
from graphnav_world.geometry.scene import Faces
from graphnav_world.rendering.camera import Camera


@dataclass(frozen=True)
class Placed:
    """The camera in W and all faces in C.

    ``heading``: cosine and sine of the robot's yaw. ``quads_C`` (prims, 4, 3), ``normal_C`` (prims, 3) and
    ``distance_m`` (prims,), of the eye before each prim's plane, are float64. ``face_distance_m`` (faces,), ``u_R``
    and ``v_R`` (4, faces), the texture coordinates as affine functions of the point relative to the eye along the
    robot's axes, are float32. ``moved``: body and its position (x, y, z) in W, for the moving ones.
    """

    eye_W: Doubles  # noqa: N815  # the frame's letter
    R_WC: Doubles
    heading: tuple[float, float]
    quads_C: Doubles  # noqa: N815  # the frame's letter
    normal_C: Doubles  # noqa: N815  # the frame's letter
    distance_m: Doubles
    face_distance_m: Floats
    u_R: Floats  # noqa: N815  # the frame's letter
    v_R: Floats  # noqa: N815  # the frame's letter
    moving: tuple[tuple[int, Doubles], ...]

    @classmethod
    def at(cls, camera: Camera, faces: Faces, x_m: float, y_m: float, yaw_rad: float, time_s: float = 0.0) -> Placed:
        """Return the faces relative to the camera of a robot at this pose and time."""
        R_WC, eye = camera.pose(x_m, y_m, yaw_rad)
        quads, offset, u, v = faces.quads, faces.offset, faces.u, faces.v
        moving = tuple(
            (body, np.append(patrol.at(time_s), 0.0)) for body, patrol in zip(faces.moving, faces.patrols, strict=True)
        )
        if moving:
            at = np.zeros((int(faces.body.max()) + 1, 3))
            for body, position in moving:
                at[body] = position
            shift = at[faces.body]
            quads = quads + shift[faces.face_of_prim][:, None]
            offset = offset + (faces.normal * shift).sum(axis=1)
            u, v = _shifted(u, shift), _shifted(v, shift)
        normal_C = faces.normal @ R_WC
        distance = faces.normal @ eye - offset
        R_RW = camera.R_RC @ R_WC.T
        return cls(
            eye_W=eye,
            R_WC=R_WC,
            heading=(float(R_RW[0, 0]), float(R_RW[0, 1])),
            quads_C=(quads - eye) @ R_WC,
            normal_C=normal_C[faces.face_of_prim],
            distance_m=distance[faces.face_of_prim],
            face_distance_m=distance.astype(np.float32),
            u_R=_seen_from(u, eye, R_RW),
            v_R=_seen_from(v, eye, R_RW),
            moving=moving,
        )

    def camera_from(self, other: Placed) -> tuple[Floats, Floats]:
        """Return the rotation (3, 3) and translation (3,) that take points in the other's C to this one's."""
        turn = self.R_WC.T @ other.R_WC
        shift = self.R_WC.T @ (other.eye_W - self.eye_W)
        return turn.astype(np.float32), shift.astype(np.float32)

    def moved_since(self, before: Placed) -> Iterator[tuple[int, Doubles]]:
        """Yield every moving body with its displacement (x, y, z) in W."""
        for (body, now), (_, then) in zip(self.moving, before.moving, strict=True):
            yield body, now - then


def _shifted(affine: Doubles, shift: Doubles) -> Doubles:
    """Return affine functions of the point in a body's frame as functions of the point in W."""
    return np.column_stack([affine[:, :3], affine[:, 3] - (affine[:, :3] * shift).sum(axis=1)])


def _seen_from(affine: Doubles, eye: Doubles, R_RW: Doubles) -> Floats:
    """Return affine functions of the point in W as functions of the point minus the eye, along R's axes."""
    at_eye = affine[:, :3] @ eye + affine[:, 3]
    seen: Floats = np.vstack([R_RW @ affine[:, :3].T, at_eye]).astype(np.float32)
    return seen
