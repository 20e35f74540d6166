"""Read the calibration of a camera as OpenCV and ROS write it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import ParamError, read_regular
from graphnav.arrays import Doubles
from graphnav_io.lens import Lens, Maps
from graphnav_io.quiet import quiet

CALIBRATE = "calibrate the camera with graphnav calibrate, OpenCV or ROS, and give the YAML file that it writes"
FISHEYE = ("equidistant", "fisheye")
PINHOLE = ("plumb_bob", "rational_polynomial", "pinhole")
NEEDED = ("image_width", "image_height", "camera_matrix", "distortion_coefficients")
MAX_PX = 65536
MAX_BYTES = 1024**2
"""Of a calibration's file."""
_COUNTS = {False: (4, 5, 8, 12, 14), True: (4,)}
"""The numbers of distortion coefficients of a pinhole and of a fisheye camera in OpenCV."""


class Calibration(NamedTuple):
    """The intrinsic parameters of a camera, of a file.

    ``rectification``: (3, 3), the rotation to the camera of the rectified picture, ``projection``: (3, 3), its camera
    matrix; None where the file has none.
    """

    path: Path
    rows: int
    cols: int
    lens: Lens
    rectification: Doubles | None = None
    projection: Doubles | None = None

    def check_size(self, rows: int, cols: int) -> None:
        """Raise ParamError unless a picture has the size that was calibrated."""
        if (rows, cols) != (self.rows, self.cols):
            raise ParamError(
                "calibration",
                f"'{self.path}' is of pictures of {self.cols}x{self.rows} pixels, but the camera's are {cols}x{rows}",
                "calibrate at the size that the camera sends; 'size' resizes later",
            )

    def maps(self, *, rectify: bool) -> Maps:
        """Return column and row of the distorted picture for every pixel of the undistorted one, each (rows, cols).

        ``rectify``: the undistorted picture is that of ``projection`` after ``rectification``, else that of the same
        focal length and centre.
        """
        turn, camera = (self.rectification, self.projection) if rectify else (np.eye(3), self.lens.camera)
        assert turn is not None, "checked when the file is read"
        assert camera is not None
        return self.lens.maps(self.rows, self.cols, turn, camera)


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
    lens = Lens(camera.reshape(3, 3), distortion, is_fisheye)
    return Calibration(path, rows, cols, lens, *_rectified(path, file))


def check_rectified(calibration: Calibration) -> None:
    """Raise ParamError unless the file says how the rectified picture is made."""
    if calibration.rectification is None or calibration.projection is None:
        what = f"'{calibration.path}' has no 'rectification_matrix' and 'projection_matrix'"
        raise ParamError("rectify", what, "calibrate with graphnav calibrate, or set rectify: false")


def calibration_text(lens: Lens, rows: int, cols: int, rectification: Doubles, projection: Doubles) -> str:
    """Return the YAML of ROS camera_info, which `read_calibration` reads; parameters as `Calibration` has them."""
    matrices = {
        "camera_matrix": lens.camera,
        "distortion_coefficients": lens.distortion.reshape(1, -1),
        "rectification_matrix": rectification,
        "projection_matrix": np.column_stack([projection, np.zeros(3)]),
    }
    lines = [
        "%YAML:1.0",
        "---",
        f"image_width: {cols}",
        f"image_height: {rows}",
        "camera_name: camera",
        f"distortion_model: {'equidistant' if lens.is_fisheye else 'plumb_bob'}",
    ]
    for name, matrix in matrices.items():
        numbers = ", ".join(f"{value:.10g}" for value in matrix.ravel().tolist())
        lines += [f"{name}:", f"  rows: {matrix.shape[0]}", f"  cols: {matrix.shape[1]}", f"  data: [{numbers}]"]
    return "\n".join(lines) + "\n"


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


def _rectified(path: Path, file: cv2.FileStorage) -> tuple[Doubles | None, Doubles | None]:
    """Return the rotation to the rectified picture and its camera matrix, None without one."""
    if file.getNode("rectification_matrix").empty() or file.getNode("projection_matrix").empty():
        return None, None
    turn, projection = (_numbers(path, file, key) for key in ("rectification_matrix", "projection_matrix"))
    if turn.size != 9 or not np.allclose(turn.reshape(3, 3) @ turn.reshape(3, 3).T, np.eye(3), atol=1e-3):
        raise _fault(path, "'rectification_matrix' is not a 3x3 rotation", CALIBRATE)
    if projection.size != 12 or projection[0] <= 0 or projection[5] <= 0:
        raise _fault(path, "'projection_matrix' is not a 3x4 matrix with positive focal lengths", CALIBRATE)
    return turn.reshape(3, 3), projection.reshape(3, 4)[:, :3]


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
