"""Read the calibration of a camera as OpenCV and ROS write it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import ParamError, read_regular
from graphnav.arrays import Doubles
from graphnav_io.quiet import quiet

CALIBRATE = "calibrate the camera with OpenCV or ROS camera_calibration, and give the YAML file that it writes"
FISHEYE = ("equidistant", "fisheye")
PINHOLE = ("plumb_bob", "rational_polynomial", "pinhole")
NEEDED = ("image_width", "image_height", "camera_matrix", "distortion_coefficients")
MAX_PX = 65536
MAX_BYTES = 1024**2
"""Of a calibration's file."""
_COUNTS = {False: (4, 5, 8, 12, 14), True: (4,)}
"""The numbers of distortion coefficients of a pinhole and of a fisheye camera in OpenCV."""


class Calibration(NamedTuple):
    """The intrinsic parameters of a camera.

    ``camera``: (3, 3), focal lengths and principal point in pixels. ``distortion``: (n,), in OpenCV's order.
    """

    path: Path
    rows: int
    cols: int
    camera: Doubles
    distortion: Doubles
    is_fisheye: bool

    def check_size(self, rows: int, cols: int) -> None:
        """Raise ParamError unless a picture has the size that was calibrated."""
        if (rows, cols) != (self.rows, self.cols):
            raise ParamError(
                "calibration",
                f"'{self.path}' is of pictures of {self.cols}x{self.rows} pixels, but the camera's are {cols}x{rows}",
                "calibrate at the size that the camera sends; 'size' resizes later",
            )

    def maps(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
        """Return column and row of the distorted picture for every pixel of the undistorted one, each (rows, cols)."""
        make = cv2.fisheye.initUndistortRectifyMap if self.is_fisheye else cv2.initUndistortRectifyMap
        x, y = make(self.camera, self.distortion, np.eye(3), self.camera, (self.cols, self.rows), cv2.CV_32FC1)
        return np.asarray(x, np.float32), np.asarray(y, np.float32)


def read_calibration(path: Path) -> Calibration:
    """Return the calibration in a YAML file of cv2.FileStorage or of ROS camera_info.

    Keys: ``image_width``, ``image_height``, ``camera_matrix`` and ``distortion_coefficients``. The lens is a fisheye
    where ``distortion_model`` is "equidistant" or "fisheye", or ``fisheye_model`` is 1; else OpenCV's pinhole model.

    Raises
    ------
    ParamError
        The file cannot be read, or lacks what is needed; names the parameter 'calibration'.
    """
    file = _read(path)
    is_fisheye = _is_fisheye(path, file)
    cols, rows = (_count(path, file, key) for key in ("image_width", "image_height"))
    camera = _numbers(path, file, "camera_matrix")
    if camera.size != 9 or camera[0] <= 0 or camera[4] <= 0:
        raise _fault(path, "'camera_matrix' is not a 3x3 matrix with positive focal lengths", CALIBRATE)
    distortion = _numbers(path, file, "distortion_coefficients")
    if distortion.size not in _COUNTS[is_fisheye]:
        kind, counts = ("fisheye", "4") if is_fisheye else ("pinhole", "4, 5, 8, 12 or 14")
        what = f"'distortion_coefficients' has {distortion.size} numbers, but a {kind} camera has {counts}"
        raise _fault(path, what, "check 'distortion_model': plumb_bob, rational_polynomial or equidistant")
    return Calibration(path, rows, cols, camera.reshape(3, 3), distortion, is_fisheye)


def _read(path: Path) -> cv2.FileStorage:
    try:
        text = read_regular(path, MAX_BYTES).decode()
    except OSError as error:
        raise ParamError("calibration", f"'{path}' cannot be read: {error.strerror}", CALIBRATE) from error
    except UnicodeDecodeError as error:
        raise _fault(path, "it is not a text file", CALIBRATE) from error
    flags = cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY | cv2.FILE_STORAGE_FORMAT_YAML
    try:
        with quiet():
            file = cv2.FileStorage(text, flags)
    except (cv2.error, SystemError) as error:
        raise _fault(path, "OpenCV cannot read it as YAML", CALIBRATE) from error
    if not file.isOpened() or not file.root().isMap():
        raise _fault(path, "it holds no calibration", CALIBRATE)
    return file


def _is_fisheye(path: Path, file: cv2.FileStorage) -> bool:
    node = file.getNode("distortion_model")
    if node.empty():
        flag = file.getNode("fisheye_model")
        return flag.isInt() and flag.real() == 1
    model = node.string() if node.isString() else ""
    if model not in (*PINHOLE, *FISHEYE):
        raise _fault(path, f"the distortion model '{model}' is not known", f"use {', '.join((*PINHOLE, *FISHEYE))}")
    return model in FISHEYE


def _count(path: Path, file: cv2.FileStorage, key: str) -> int:
    node = _node(path, file, key)
    if not node.isInt() or not 0 < node.real() <= MAX_PX:
        raise _fault(path, f"'{key}' is not a number of pixels", "write the size of the calibrated pictures")
    return int(node.real())


def _numbers(path: Path, file: cv2.FileStorage, key: str) -> Doubles:
    node = _node(path, file, key)
    data = node.getNode("data") if node.isMap() else node
    cells = [data.at(k) for k in range(data.size())] if data.isSeq() else []
    numbers = np.array([cell.real() if cell.isReal() or cell.isInt() else np.nan for cell in cells], np.float64)
    if not numbers.size or not np.isfinite(numbers).all():
        raise _fault(path, f"'{key}' does not hold a list of finite numbers", CALIBRATE)
    return numbers


def _node(path: Path, file: cv2.FileStorage, key: str) -> cv2.FileNode:
    node = file.getNode(key)
    if node.empty():
        raise _fault(path, f"it has no '{key}'", f"add it: the file needs {', '.join(NEEDED)}")
    return node


def _fault(path: Path, what: str, hint: str) -> ParamError:
    return ParamError("calibration", f"'{path}': {what}", hint)
