"""The lens of a camera, by OpenCV's models of a pinhole with distortion and of a fisheye."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from graphnav.arrays import Doubles

Maps = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
STOP: Any = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)
"""Of OpenCV's iterations."""


@dataclass(frozen=True)
class Lens:
    """A camera matrix (3, 3), pixels, and distortion coefficients (n,) in OpenCV's order."""

    camera: Doubles
    distortion: Doubles
    is_fisheye: bool

    def rays(self, points_px: Doubles) -> Doubles:
        """Return where points (n, 2) lie in a picture of focal length 1 without distortion."""
        undistort: Any = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)  # called so before OpenCV 5
        if self.is_fisheye:
            undistort = cv2.fisheye.undistortPoints
        points = np.ascontiguousarray(points_px, np.float64).reshape(-1, 1, 2)
        found = undistort(points, self.camera, self.distortion, R=np.eye(3), P=np.eye(3), criteria=STOP)
        return np.asarray(found, np.float64).reshape(-1, 2)

    def project(self, points: Doubles, turn: Doubles, shift: Doubles) -> Doubles:
        """Return the pixels of points (n, 3) after a rotation (vector) and a shift into the camera's frame."""
        project = cv2.fisheye.projectPoints if self.is_fisheye else cv2.projectPoints
        found = project(points.reshape(-1, 1, 3), turn, shift, self.camera, self.distortion)[0]
        return np.asarray(found, np.float64).reshape(-1, 2)

    def maps(self, rows: int, cols: int, rectification: Doubles, projection: Doubles) -> Maps:
        """Return column and row of the distorted picture for every pixel of the undistorted one, each (rows, cols).

        The undistorted picture is that of the camera matrix ``projection`` (3, 3) after the rotation ``rectification``.
        """
        make = cv2.fisheye.initUndistortRectifyMap if self.is_fisheye else cv2.initUndistortRectifyMap
        x, y = make(self.camera, self.distortion, rectification, projection, (cols, rows), cv2.CV_32FC1)
        return np.asarray(x, np.float32), np.asarray(y, np.float32)
