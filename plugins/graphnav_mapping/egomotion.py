"""Visual odometry: the motion of a frame from the flow of the floor."""

from __future__ import annotations

import math

import numpy as np

from graphnav import Flow, Motion, Mount, Plane, Stage, coarsen, param
from graphnav.arrays import Bools, Doubles

MIN_VECTORS = 12
_ITERATIONS = 4
_RIDGE = 1e-9


class Egomotion(Stage):
    """Motion of the frame from the flow of the floor, in metres, by a camera of known mounting.

    The flow of floor points depends on the forward displacement, the turn, and the pitch and roll by which the camera
    shakes: to first order it is linear in these four [LHP]. They are fitted to the cells that the detector calls
    ground, by reweighted least squares (Geman and McClure's estimator). The positions are taken midway between both
    frames, which makes the fit exact to second order. The robot cannot slip sideways: it drives along an arc.

    Publishes nothing where fewer than 12 ground cells have a vector; one that is longer than the picture is none.

    References
    ----------
    .. [LHP] H. C. Longuet-Higgins, K. Prazdny, The Interpretation of a Moving Retinal Image, Proceedings of the Royal
       Society B 208, 1980.
    """

    camera_height_m: float = param(1.0, ge=0.01, le=100.0, doc=Mount.HEIGHT_DOC)
    tilt_deg: float = param(75.0, gt=0.0, le=90.0, doc=Mount.TILT_DOC)
    fov_deg: float = param(70.0, ge=5.0, le=150.0, doc=Mount.FOV_DOC)
    camera_forward_m: float = param(0.0, ge=-100.0, le=100.0, doc=Mount.FORWARD_DOC)
    shakes: bool = param(True, doc="whether pitch and roll are estimated too; false: the camera is rigid")
    noise_px: float = param(
        0.1, ge=0.001, le=100.0, doc="flow noise: a vector that differs by this has a weight of a quarter"
    )
    max_distance_m: float = param(
        3.0, gt=0.0, le=1000.0, doc="distance on the floor beyond which the flow is too short to count"
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget the picture's size."""
        self._mount = Mount(self.camera_height_m, self.tilt_deg, self.fov_deg, self.camera_forward_m)
        self._near: Bools = np.zeros((0, 0), np.bool_)

    def step(self, flow: Flow, plane: Plane) -> Motion | None:
        """Return the motion since the last frame.

        Raises
        ------
        ValueError
            Flow and plane are of different image sizes.
        """
        cells = coarsen(flow, plane.step_px)
        if cells.valid.shape != plane.valid.shape:
            raise ValueError(
                f"the flow has {cells.valid.shape[1]}x{cells.valid.shape[0]} cells of {plane.step_px} px, but the "
                f"plane {plane.valid.shape[1]}x{plane.valid.shape[0]}: wire the flow from which the plane is made"
            )
        if self._near.shape != plane.valid.shape:
            self._near = self._mount.floor_distance_m(*plane.valid.shape) < self.max_distance_m
            self._rays = self._mount.rays(*plane.valid.shape).reshape(-1, 3)
        counts = self._near & (cells.valid != 0) & (plane.valid != 0) & (plane.obstacle == 0)
        counts &= (np.abs(cells.uv_px) <= plane.step_px * max(counts.shape)).all(axis=-1)
        if np.count_nonzero(counts) < MIN_VECTORS:
            return None
        moved = self._fitted(cells, counts)
        chord_m, turn_rad = float(moved[0]), float(moved[1])
        return Motion(
            forward_m=chord_m * math.cos(turn_rad / 2),
            left_m=chord_m * math.sin(turn_rad / 2),
            turn_rad=turn_rad,
            interval_us=flow.interval_us,
        )

    def _fitted(self, cells: Flow, counts: Bools) -> Doubles:
        """Return forward displacement, turn, pitch and roll by the cells that count, metres and radians."""
        rows, cols = counts.shape
        focal_px = self._mount.intrinsics(rows, cols)[0, 0]
        counted = np.flatnonzero(counts)
        uv = cells.uv_px.reshape(-1, 2).take(counted, axis=0).astype(np.float64) / (cells.step_px * focal_px)
        rays = self._rays.take(counted, axis=0)
        rays[:, :2] -= uv / 2
        columns = self._mount.floor_flow(rays)[: 4 if self.shakes else 2]
        equations = columns.reshape(len(columns), -1).T
        measured = uv.T.reshape(-1)
        noise = self.noise_px / (cells.step_px * focal_px)
        weight, ridge = np.ones(len(uv)), _RIDGE * np.eye(len(columns))
        for _ in range(_ITERATIONS):
            weighted = equations.T * np.concatenate([weight, weight])
            moved = np.linalg.solve(weighted @ equations + ridge, weighted @ measured)
            left = np.square(measured - equations @ moved).reshape(2, -1)
            weight = 1.0 / np.square(1.0 + (left[0] + left[1]) / noise**2)
        return np.asarray(moved)
