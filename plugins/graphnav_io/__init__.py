"""Stages of the family ``io``: images from files, cameras and streams, prepared; recorded drives."""

from __future__ import annotations

from pathlib import Path

from graphnav import CalibrationBoard, CalibrationTask, CameraCalibration, Stage, hookimpl


@hookimpl
def graphnav_stages() -> list[type[Stage]]:
    """Return the stages; their modules are imported only now."""
    from graphnav_io.camera import Camera
    from graphnav_io.images import Images
    from graphnav_io.prepare import Prepare
    from graphnav_io.recording import Recording
    from graphnav_io.undistort import Undistort
    from graphnav_io.video import Video

    return [Images, Video, Camera, Recording, Prepare, Undistort]


@hookimpl
def graphnav_calibrate(task: CalibrationTask) -> CameraCalibration:
    """Calibrate a camera from pictures of a board."""
    from graphnav_io.calibrate import calibrate

    return calibrate(task)


@hookimpl
def graphnav_print_board(board: CalibrationBoard, file: Path) -> tuple[float, float]:
    """Write a calibration board to be printed."""
    from graphnav_io.boards import print_board

    return print_board(board, file)
