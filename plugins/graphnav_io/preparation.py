"""Prepare pictures: convert to gray, undistort, rotate, crop, resize, in this order."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import ParamError, Stage, param
from graphnav.arrays import Bytes
from graphnav_io.calibration import Calibration, check_rectified, read_calibration
from graphnav_io.lens import Maps
from graphnav_io.picture_size import MAX_PIXELS

Rotation = Literal[0, 90, 180, 270]


class Prepared(Stage):
    """The parameters of stages that prepare pictures."""

    calibration: Path | None = param(
        None,
        doc="calibration of the camera (YAML of cv2.FileStorage or ROS camera_info): pictures are undistorted first, "
        "with the same focal length and centre; pixels that the camera does not see become black; null keeps the lens",
    )
    rectify: bool = param(
        False,
        doc="undistort to the picture of the calibration's projection_matrix after its rectification_matrix; those "
        "that graphnav calibrate writes make the camera level, its optical axis in the middle and its pixels square",
    )
    rotate_deg: Rotation = param(0, doc="rotation of the undistorted picture, counterclockwise")
    crop_px: tuple[int, int, int, int] | None = param(
        None,
        ge=0,
        le=65536,
        doc="left, top, right and bottom of the part to keep, in pixels of the rotated picture, right and bottom "
        "excluded; null keeps all",
    )
    crop_ratio: tuple[float, float, float, float] | None = param(
        None, ge=0.0, le=1.0, doc="the same as shares of the picture's columns and rows, such as [0, 0.4, 1, 1]"
    )
    crop_top_ratio: float = param(
        0.0,
        ge=0.0,
        lt=1.0,
        doc="share of the rotated picture's rows to crop at the top and nothing else: what a forward camera sees above "
        "the ground",
    )
    size: tuple[int, int] | None = param(
        None, ge=1, le=16384, doc="columns and rows to resize the cropped picture to; null keeps the size"
    )
    scale: float = param(1.0, gt=0.0, le=16.0, doc="dimensionless: factor to resize by if no size is given")
    gray: bool = param(False, doc="convert colours to gray: a third of the bytes")

    def check(self) -> None:
        """Check that the parameters agree and that the calibration can be read."""
        if errors := list(self._errors()):
            raise ExceptionGroup("the preparation of pictures", errors)

    def _errors(self) -> Iterator[ParamError]:
        if self.size is not None and self.scale != 1.0:
            yield ParamError("scale", f"'scale' is {self.scale:g}, but 'size' is given too", "remove one of them")
        if self.crop_px is not None and self.crop_ratio is not None:
            yield ParamError("crop_px", "'crop_px' and 'crop_ratio' are both given", "remove one of them")
        for name, box in (("crop_px", self.crop_px), ("crop_ratio", self.crop_ratio)):
            if box is not None and self.crop_top_ratio:
                what = f"'crop_top_ratio' is {self.crop_top_ratio:g}, but '{name}' is given too"
                yield ParamError("crop_top_ratio", what, f"set it to 0, or remove '{name}'")
        if self.size is not None and self.size[0] * self.size[1] > MAX_PIXELS:
            what = f"'size' is {list(self.size)}, which is more than {MAX_PIXELS // 10**6} million pixels"
            yield ParamError("size", what, "give fewer columns or rows")
        for name, box in (("crop_px", self.crop_px), ("crop_ratio", self.crop_ratio)):
            if box is not None and (box[0] >= box[2] or box[1] >= box[3]):
                what = f"'{name}' is {list(box)}, which is empty"
                yield ParamError(name, what, "give left < right and top < bottom, in this order")
        try:
            self._read()
        except ParamError as error:
            yield error

    def check_picture(self, pixels: Bytes) -> None:
        """Check that the parameters fit a picture of the camera, before the run.

        Raises
        ------
        ParamError
            The picture does not have the size of the calibration, or the crop leaves it.
        """
        rows, cols = self._remap().apply(pixels).shape[:2]
        if rows * cols * self.scale**2 > MAX_PIXELS:
            limit = f"{MAX_PIXELS // 10**6} million pixels"
            what = f"'scale' is {self.scale:g}, which makes more than {limit} of {cols}x{rows}"
            raise ParamError("scale", what, "give a smaller one, or a 'size'")

    def preparation(self) -> Preparation:
        """Return the preparation that the parameters describe."""
        return Preparation(self._remap(), self.size, self.scale, gray=self.gray)

    def _remap(self) -> Remap:
        return Remap(self._read(), self.rectify, self.rotate_deg, self.crop_px, self.crop_ratio, self.crop_top_ratio)

    def _read(self) -> Calibration | None:
        if self.calibration is None:
            if self.rectify:
                raise ParamError("rectify", "'rectify' is true, but there is no calibration", "give 'calibration'")
            return None
        calibration = read_calibration(self.calibration)
        if self.rectify:
            check_rectified(calibration)
        return calibration


class Preparation:
    """Prepares the pictures of one camera; maps are computed for the first one, which fixes the size."""

    def __init__(self, remap: Remap, size: tuple[int, int] | None, scale: float, *, gray: bool) -> None:
        self._remap, self._size, self._scale, self._gray = remap, size, scale, gray
        self._first: tuple[int, ...] | None = None

    def apply(self, pixels: Bytes) -> Bytes:
        """Return a picture, uint8 (rows, cols) or (rows, cols, 3), prepared.

        Raises
        ------
        ValueError
            The picture does not have the size of the calibration or of the first frame, or the crop leaves it.
        """
        if self._gray and pixels.ndim == 3:
            pixels = cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
        try:
            pixels = self._resized(self._remap.apply(pixels))
        except ParamError as error:
            raise ValueError(f"{error.what}; {error.hint}") from error
        if self._first is None:
            self._first = pixels.shape
        elif pixels.shape[:2] != self._first[:2]:
            (rows, cols), (first_rows, first_cols) = pixels.shape[:2], self._first[:2]
            raise ValueError(f"a frame is {cols}x{rows}, but the first was {first_cols}x{first_rows}: set 'size'")
        return pixels

    def _resized(self, pixels: Bytes) -> Bytes:
        rows, cols = pixels.shape[:2]
        size = self._size or (max(1, round(cols * self._scale)), max(1, round(rows * self._scale)))
        if size == (cols, rows):
            return pixels
        shrinks = size[0] * size[1] < rows * cols
        resized: Bytes = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
        return resized


class Remap:
    """Undistorts, rotates, then crops.

    Without a calibration pixels are only moved. With one, the maps for ``cv2.remap`` are computed once, rotated and
    cropped themselves, so that every picture is interpolated once, and only where it is kept.
    """

    def __init__(
        self,
        calibration: Calibration | None,
        rectify: bool,  # noqa: FBT001 - as the parameter
        rotate_deg: int,
        crop_px: tuple[int, int, int, int] | None,
        crop_ratio: tuple[float, float, float, float] | None,
        crop_top_ratio: float,
    ) -> None:
        self._calibration, self._rectify, self._turns = calibration, rectify, rotate_deg // 90
        self._crop_px, self._crop_ratio, self._crop_top_ratio = crop_px, crop_ratio, crop_top_ratio
        self._maps: Maps | None = None

    def apply(self, pixels: Bytes) -> Bytes:
        """Return the picture undistorted, rotated and cropped.

        Raises
        ------
        ParamError
            The picture does not have the size of the calibration, or the crop leaves it.
        """
        if self._calibration is None:
            crops = self._crop_px is not None or self._crop_ratio is not None or self._crop_top_ratio > 0
            if not self._turns and not crops:
                return pixels
            return np.ascontiguousarray(self._moved(pixels))
        self._calibration.check_size(*pixels.shape[:2])
        if self._maps is None:
            x, y = self._calibration.maps(rectify=self._rectify)
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
            top = round(self._crop_top_ratio * rows)
            if top == rows:
                what = f"'crop_top_ratio' is {self._crop_top_ratio:g}, which leaves no pixel of {cols}x{rows}"
                raise ParamError("crop_top_ratio", what, "crop less")
            return 0, top, cols, rows
        sides = np.array([cols, rows, cols, rows])
        left, top, right, bottom = np.rint(np.array(self._crop_ratio) * sides).astype(int).tolist()
        if left >= right or top >= bottom:
            what = f"'crop_ratio' is {list(self._crop_ratio)}, which leaves no pixel of {cols}x{rows}"
            raise ParamError("crop_ratio", what, "keep a larger part")
        return left, top, right, bottom
