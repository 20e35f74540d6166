"""Undistort, rotate and crop pictures in one pass."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import ParamError
from graphnav.arrays import Bytes
from graphnav_io.calibration import Calibration

Maps = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]


class Remap:
    """Undistorts, rotates, then crops.

    Without a calibration pixels are only moved. With one, the maps for ``cv2.remap`` are computed once, rotated and
    cropped themselves, so that every picture is interpolated once, and only where it is kept.
    """

    def __init__(
        self,
        calibration: Calibration | None,
        rotate_deg: int,
        crop_px: tuple[int, int, int, int] | None,
        crop_ratio: tuple[float, float, float, float] | None,
    ) -> None:
        self._calibration, self._turns = calibration, rotate_deg // 90
        self._crop_px, self._crop_ratio = crop_px, crop_ratio
        self._maps: Maps | None = None

    def apply(self, pixels: Bytes) -> Bytes:
        """Return the picture undistorted, rotated and cropped.

        Raises
        ------
        ParamError
            The picture does not have the size of the calibration, or the crop leaves it.
        """
        if self._calibration is None:
            if not self._turns and self._crop_px is None and self._crop_ratio is None:
                return pixels
            return np.ascontiguousarray(self._moved(pixels))
        self._calibration.check_size(*pixels.shape[:2])
        if self._maps is None:
            x, y = self._calibration.maps()
            self._maps = np.ascontiguousarray(self._moved(x)), np.ascontiguousarray(self._moved(y))
        return np.asarray(cv2.remap(pixels, *self._maps, cv2.INTER_LINEAR), np.uint8)

    def _moved(self, grid: npt.NDArray[np.generic]) -> npt.NDArray[np.generic]:
        """Return a grid of pixels rotated and cropped."""
        turned = np.rot90(grid, self._turns)
        left, top, right, bottom = self._box(*turned.shape[:2])
        return turned[top:bottom, left:right]

    def _box(self, rows: int, cols: int) -> tuple[int, int, int, int]:
        if self._crop_px is not None:
            _, _, right, bottom = self._crop_px
            if right > cols or bottom > rows:
                what = f"'crop_px' is {list(self._crop_px)}, but the rotated picture has {cols} columns and {rows} rows"
                raise ParamError("crop_px", what, "keep right and bottom within it, or use 'crop_ratio'")
            return self._crop_px
        if self._crop_ratio is None:
            return 0, 0, cols, rows
        sides = np.array([cols, rows, cols, rows])
        left, top, right, bottom = np.rint(np.array(self._crop_ratio) * sides).astype(int).tolist()
        if left >= right or top >= bottom:
            what = f"'crop_ratio' is {list(self._crop_ratio)}, which leaves no pixel of {cols}x{rows}"
            raise ParamError("crop_ratio", what, "keep a larger part")
        return left, top, right, bottom
