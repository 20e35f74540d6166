"""The arguments and results of hooks that calibrate a camera: boards, judged pictures, lens and mounting."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from graphnav.core.errors import Problem


@dataclass(frozen=True)
class CalibrationBoard:
    """A flat board of black and white squares.

    ``cols``, ``rows``: inner corners of a checkerboard, as OpenCV and ROS count; squares of a ChArUco board.
    ``marker_m``: the side of a ChArUco board's markers, None for a checkerboard; ``dictionary``: theirs, as OpenCV
    names it without ``DICT_``.
    """

    cols: int
    rows: int
    square_m: float
    marker_m: float | None = None
    dictionary: str = "4X4_50"

    @property
    def name(self) -> str:
        """The board in words."""
        what = "inner corners" if self.marker_m is None else "squares with markers"
        return f"{self.cols}x{self.rows} {what}"


@dataclass(frozen=True)
class CalibrationTask:
    """The pictures and the board of a calibration.

    ``pictures``, ``floor``: pictures, folders or patterns of them, videos, logs and run folders with images; the board
    lies on the floor in those of ``floor``. ``rotate_deg``: how far the pictures are turned counterclockwise until
    the robot's front is up. ``is_fisheye``: whether OpenCV's fisheye model is fitted. ``sheet``: the picture to write
    of what was found.
    """

    pictures: tuple[Path, ...]
    floor: tuple[Path, ...]
    board: CalibrationBoard
    sheet: Path
    rotate_deg: int = 0
    is_fisheye: bool = False


class Estimate(NamedTuple):
    """A number and its standard deviation."""

    value: float
    deviation: float


class BoardPicture(NamedTuple):
    """A picture of the board: what was found, and why it is not used.

    ``rms_px``: the reprojection error, None where it was not computed. ``refusal``: empty for a picture that is used.
    """

    name: str
    n_corners: int
    rms_px: float | None
    refusal: str


class FloorPicture(NamedTuple):
    """A picture of the board on the floor, and the mounting that it gives; NaN where no board was found."""

    name: str
    n_corners: int
    height_m: float
    tilt_deg: float
    roll_deg: float
    refusal: str


class LensFit(NamedTuple):
    """The intrinsic parameters of a camera, in pixels of its pictures, with standard deviations.

    ``distortion``: by the names of OpenCV's coefficients. ``fov_deg``: what the picture shows across, down and from
    corner to corner through the lens. ``coverage_ratio``: the share of the picture's 8 x 6 cells that hold corners.
    """

    cols: int
    rows: int
    fx_px: Estimate
    fy_px: Estimate
    cx_px: Estimate
    cy_px: Estimate
    distortion: dict[str, Estimate]
    is_fisheye: bool
    rms_px: float
    fov_deg: tuple[float, float, float]
    coverage_ratio: float


class CameraMounting(NamedTuple):
    """Where the camera is: medians over pictures of the floor; the deviation is that of one picture, NaN for one.

    ``height_m`` above the floor, ``tilt_deg`` of the optical axis below the horizontal, ``roll_deg`` about the robot's
    forward axis, above 0 with the camera's right side lower.
    """

    height_m: Estimate
    tilt_deg: Estimate
    roll_deg: Estimate


class PreparedCamera(NamedTuple):
    """The camera of the undistorted, level picture, for the parameters of stages; None without pictures of the floor.

    ``cols``, ``rows``: of the picture after ``rotate_deg``; ``fov_deg``: its horizontal field of view.
    """

    cols: int
    rows: int
    fov_deg: float
    height_m: float | None
    tilt_deg: float | None


class CameraCalibration(NamedTuple):
    """Result of a calibration: every picture, the lens and the mounting.

    ``problem``: why there is no calibration; ``lens``, ``mounting`` and ``prepared`` are then what could be computed.
    ``text``: the calibration's file, YAML of ROS camera_info, as ``io.prepare`` reads it. ``notices``: doubts.
    """

    pictures: tuple[BoardPicture, ...]
    floor: tuple[FloorPicture, ...]
    lens: LensFit | None
    mounting: CameraMounting | None
    prepared: PreparedCamera | None
    text: str
    notices: tuple[str, ...]
    problem: Problem | None
