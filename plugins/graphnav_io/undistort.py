"""Undistort the pictures of a live camera by what its driver says of it."""

from __future__ import annotations

import cv2
import numpy as np

from graphnav import CameraInfo, Image, Latest, Stage, param
from graphnav_io.lens import Lens, Maps

MAX_ERROR = 0.01
"""Of the determinant of a rotation."""


class Undistort(Stage):
    """Undistort pictures by the `CameraInfo` that the driver of the camera publishes; `io.prepare` may follow.

    Pictures that come before the first information are left out. A new one, other than the one before, makes new maps.
    Pixels that the camera does not see become black.
    """

    rectify: bool = param(
        False,
        doc="undistort to the picture of the information's projection after its rectification; false keeps the focal "
        "lengths and the principal point",
    )

    def reset(self, seed: int) -> None:  # noqa: ARG002  # nothing is random
        """Forget what is known of the camera."""
        self._info: CameraInfo | None = None
        self._maps: Maps | None = None

    def step(self, image: Image, info: Latest[CameraInfo]) -> Image | None:
        """Return the undistorted picture, None before anything is known of the camera.

        Raises
        ------
        ValueError
            The picture has another size than the one that was calibrated, or it cannot be rectified.
        """
        if info.value is None:
            return None
        rows, cols = image.pixels.shape[:2]
        if (rows, cols) != (info.value.rows, info.value.cols):
            what = f"a picture has {cols}x{rows} pixels, but its camera's information is of"
            raise ValueError(f"{what} {info.value.cols}x{info.value.rows}: calibrate at the size that the camera sends")
        if self._info is not info.value:
            self._learn(info.value)
        assert self._maps is not None
        return Image(pixels=np.asarray(cv2.remap(image.pixels, *self._maps, cv2.INTER_LINEAR), np.uint8))

    def _learn(self, info: CameraInfo) -> None:
        """Make the maps of a camera, unless they are those of the one before."""
        before, self._info = self._info, info
        if before is not None and all(map(np.array_equal, vars(before).values(), vars(info).values())):
            return
        projection = info.projection[:, :3]
        has_projection = projection[0, 0] > 0.0 and projection[1, 1] > 0.0
        if self.rectify and not (has_projection and abs(np.linalg.det(info.rectification) - 1.0) < MAX_ERROR):
            what = "the camera's information has no projection, or a rectification that is not a rotation"
            raise ValueError(f"{what}: publish both, or set rectify: false")
        distortion = info.distortion if info.distortion.size else np.zeros(4)
        lens = Lens(info.camera, distortion, info.model == "equidistant")
        target = (info.rectification, projection) if self.rectify else (np.eye(3), info.camera)
        self._maps = lens.maps(info.rows, info.cols, *target)
