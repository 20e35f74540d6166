"""``graphnav.calibrate``: the camera's lens and mounting from pictures of a board, from Python."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

from graphnav import CalibrationBoard, CalibrationTask, CameraCalibration, UserError
from graphnav.core.api import Argument, PathLike, Shared
from graphnav.core.parameters import Parameter, documented
from graphnav.develop import calibration_parameters as parameters
from graphnav.develop.calibrating import calibrated, written_files


@documented(
    parameters.PICTURES,
    parameters.BOARD,
    parameters.SQUARE_M,
    parameters.MARKER_M,
    parameters.DICTIONARY,
    parameters.FLOOR,
    parameters.ROTATE_DEG,
    parameters.FISHEYE,
    Shared.GRAPH,
    parameters.COLUMNS,
    parameters.OUTPUT,
    parameters.FORCE,
)
def calibrate(
    pictures: Sequence[PathLike],
    *,
    board: str,
    square_m: float,
    marker_m: float | None = None,
    dictionary: str = "4X4_50",
    floor: Sequence[PathLike] = (),
    rotate_deg: int = 0,
    fisheye: bool = False,
    graph: PathLike = "navigate_robot",
    columns: int = 160,
    output: PathLike = "my_camera.yaml",
    force: bool = False,
) -> CameraCalibration:
    """Return what pictures of a board tell of a camera, and write the files that graphs extend.

    The contact sheet is written also where there is no calibration.

    Raises
    ------
    UserError
        An argument cannot be used, a file exists, or the pictures do not give a calibration.
    """
    cols, rows = _read(board, parameters.BOARD)
    files = written_files(Argument(output, parameters.OUTPUT).path(), force=force)
    marker = None if marker_m is None else _read(marker_m, parameters.MARKER_M)
    Argument(str(rotate_deg), parameters.ROTATE_DEG).check_choice()
    task = CalibrationTask(
        Argument(pictures, parameters.PICTURES).paths(),
        Argument(floor, parameters.FLOOR).paths(),
        CalibrationBoard(cols, rows, _read(square_m, parameters.SQUARE_M), marker, dictionary),
        files.sheet,
        rotate_deg,
        fisheye,
    )
    found = calibrated(task, str(Argument(graph, Shared.GRAPH).path()), _read(columns, parameters.COLUMNS), files)
    if found.problem is not None:
        raise UserError(found.problem)
    return found


def _read(value: object, parameter: Parameter) -> Any:
    """Return a value as the command line would read it."""
    assert parameter.type is not None
    try:
        return parameter.type(str(value))
    except argparse.ArgumentTypeError as error:
        raise UserError.of(f"{parameter.name}: {error}", parameter.hint) from error
