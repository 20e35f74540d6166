"""Fit the model of a lens to pictures of a board, and judge whether the pictures determine it.

OpenCV's models after Z. Zhang, A Flexible New Technique for Camera Calibration, 2000, and for fisheyes J. Kannala, S.
Brandt, A Generic Camera Model and Calibration Method, 2006.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import cv2
import numpy as np

from graphnav.arrays import Doubles
from graphnav_io.boards import Corners
from graphnav_io.lens import STOP, Lens
from graphnav_io.quiet import quiet

PINHOLE_NAMES = ("k1", "k2", "p1", "p2", "k3")
FISHEYE_NAMES = ("k1", "k2", "k3", "k4")
CLEAR_DEVIATIONS = 3.0
"""k3 is kept where it differs from 0 by so many of its standard deviations: else it only bends the edges."""
OUTLIER_RATIO, OUTLIER_PX = 3.0, 0.5
"""A picture whose error is so many times the median, and more than this, does not fit the others."""
MAX_REFITS = 5
_FLAGS: Any = cv2 if hasattr(cv2, "CALIB_RECOMPUTE_EXTRINSIC") else cv2.fisheye  # where they were before OpenCV 5
_FISHEYE = _FLAGS.CALIB_RECOMPUTE_EXTRINSIC | _FLAGS.CALIB_FIX_SKEW


class Fit(NamedTuple):
    """A fitted lens.

    ``deviations``: standard deviations of fx, fy, cx, cy and the coefficients. ``rms_px``: of all corners;
    ``picture_px``: of the corners of each picture. ``normals``: (pictures, 3), of the boards in the camera's frame.
    """

    lens: Lens
    deviations: Doubles
    rms_px: float
    picture_px: Doubles
    normals: Doubles

    @property
    def focal_ratio(self) -> float:
        """The larger standard deviation of a focal length, as its share."""
        return float(max(self.deviations[k] / self.lens.camera[k, k] for k in (0, 1)))

    @property
    def turned_deg(self) -> float:
        """The largest angle between two boards."""
        cosines = np.clip(self.normals @ self.normals.T, -1.0, 1.0)
        return math.degrees(math.acos(float(cosines.min())))


def fit_lens(found: Sequence[Corners], rows: int, cols: int, *, is_fisheye: bool) -> Fit:
    """Return the lens that fits the corners of several pictures best.

    Raises
    ------
    ValueError
        OpenCV finds none.
    """
    try:
        with quiet():
            if is_fisheye:
                return _fisheye(found, rows, cols)
            simple = _pinhole(found, rows, cols, cv2.CALIB_FIX_K3)
            full = _pinhole(found, rows, cols, 0)
    except cv2.error as error:
        raise ValueError("no lens fits the corners") from error
    is_clear = abs(full.lens.distortion[4]) > CLEAR_DEVIATIONS * full.deviations[8]
    return full if is_clear else simple


def outlier(fit: Fit) -> int | None:
    """Return the picture that fits the others worst if it does not fit them; without it the rest may fit."""
    worst = int(fit.picture_px.argmax())
    limit = max(OUTLIER_PX, OUTLIER_RATIO * float(np.median(fit.picture_px)))
    return worst if fit.picture_px[worst] > limit else None


def _pinhole(found: Sequence[Corners], rows: int, cols: int, flags: int) -> Fit:
    places, points = _arrays(found)
    rms, camera, distortion, turns, _, deviations, _, per_picture = cv2.calibrateCameraExtended(
        places, points, (cols, rows), np.eye(3), np.zeros(5), flags=flags, criteria=STOP
    )
    lens = Lens(np.asarray(camera), np.asarray(distortion).reshape(-1)[:5], is_fisheye=False)
    return Fit(lens, np.asarray(deviations).reshape(-1)[:9], rms, np.asarray(per_picture).reshape(-1), _normals(turns))


def _fisheye(found: Sequence[Corners], rows: int, cols: int) -> Fit:
    places, points = ([one.reshape(1, *one.shape).astype(np.float64) for one in many] for many in _arrays(found))
    camera, distortion = np.eye(3), np.zeros((4, 1))
    rms, camera, distortion, turns, shifts = cv2.fisheye.calibrate(
        places, points, (cols, rows), camera, distortion, flags=_FISHEYE, criteria=STOP
    )
    lens = Lens(np.asarray(camera), np.asarray(distortion).reshape(-1), is_fisheye=True)
    errors = [
        lens.project(one.places_m, turn, shift) - one.points_px
        for one, turn, shift in zip(found, turns, shifts, strict=True)
    ]
    per_picture = np.array([math.sqrt(np.square(error).sum(axis=1).mean()) for error in errors])
    return Fit(lens, _deviations(found, lens, turns, shifts, errors), rms, per_picture, _normals(turns))


def _deviations(
    found: Sequence[Corners], lens: Lens, turns: Sequence[Doubles], shifts: Sequence[Doubles], errors: list[Doubles]
) -> Doubles:
    """Return the standard deviations that OpenCV computes for pinholes: of least squares, linear about the optimum."""
    n_lens = 4 + len(FISHEYE_NAMES)
    n_rows, n_all = 2 * sum(len(one.points_px) for one in found), n_lens + 6 * len(found)
    jacobian, row = np.zeros((n_rows, n_all)), 0
    for number, (one, turn, shift) in enumerate(zip(found, turns, shifts, strict=True)):
        points = one.places_m.reshape(-1, 1, 3)
        _, partial = cv2.fisheye.projectPoints(points, turn, shift, lens.camera, lens.distortion)
        here = slice(row, row + len(partial))
        jacobian[here, :n_lens] = partial[:, :n_lens]
        jacobian[here, n_lens + 6 * number : n_lens + 6 * number + 6] = partial[:, n_lens : n_lens + 6]
        row = here.stop
    variance = float(np.square(np.concatenate(errors)).sum()) / max(1, n_rows - n_all)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * variance
    return np.sqrt(np.maximum(np.diag(covariance)[:n_lens], 0.0))


def _arrays(found: Sequence[Corners]) -> tuple[list[Doubles], list[Doubles]]:
    places = [one.places_m.astype(np.float32) for one in found]
    points = [one.points_px.astype(np.float32) for one in found]
    return places, points  # type: ignore[return-value]


def _normals(turns: Sequence[Doubles]) -> Doubles:
    return np.array([cv2.Rodrigues(np.asarray(turn))[0][:, 2] for turn in turns])
