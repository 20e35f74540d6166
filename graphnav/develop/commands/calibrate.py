"""``graphnav calibrate``: the lens and the mounting of a camera, from pictures of a board."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from graphnav import Place, UserError
from graphnav.core.api import Shared
from graphnav.core.cli import CommandArguments, Exit, Options
from graphnav.core.notices import print_notice
from graphnav.core.parameters import Parameter, command
from graphnav.develop import calibration_parameters as parameters

if TYPE_CHECKING:
    from collections.abc import Iterator

    from graphnav import CalibrationBoard, CameraCalibration
    from graphnav.develop.calibrating import CameraFiles

_EXAMPLES = """\
examples:
  graphnav calibrate --print-board board.pdf --board 9x6 --square 0.025
  graphnav calibrate pictures/ --board 9x6 --square 0.025 --floor floor/
  graphnav calibrate drive.mp4 --board 8x6 --square 0.03 --charuco --marker 0.022
  graphnav run my_graph.yaml          # extends: [navigate_robot, my_camera.yaml]
"""
_MARKER_RATIO = 0.75


@command(
    parameters.PICTURES,
    parameters.BOARD.but(required=True),
    parameters.SQUARE_M.but(required=True),
    parameters.CHARUCO,
    parameters.MARKER_M,
    parameters.DICTIONARY,
    parameters.FLOOR,
    parameters.ROTATE_DEG,
    parameters.FISHEYE,
    Shared.GRAPH.but(
        flags="--graph", default="navigate_robot", help="whose stages the YAML is for (default: %(default)s)"
    ),
    parameters.COLUMNS,
    parameters.OUTPUT,
    parameters.FORCE,
    Parameter(
        "print_board",
        "--print-board",
        type=Path,
        metavar="FILE",
        help="write the board to print (.pdf or .png) in place of calibrating",
    ),
    Options.JSON,
    examples=_EXAMPLES,
)
def main(args: CommandArguments) -> int:
    """Run the command: tell of every picture, then of the camera, and write the files."""
    from graphnav import CalibrationTask
    from graphnav.develop.calibrating import calibrated, written_files

    board = _board(args)
    if args.print_board is not None:
        return _print_board(board, args)
    files = written_files(args.output, force=args.force)
    task = CalibrationTask(
        tuple(args.pictures), tuple(args.floor), board, files.sheet, int(args.rotate_deg), args.fisheye
    )
    found = calibrated(task, args.graph, args.columns, files)
    if args.json:
        print(json.dumps(_as_json(found, files), indent=2))
    else:
        _print(found, files)
    for notice in found.notices:
        print_notice(notice)
    if found.problem is not None:
        raise UserError(found.problem)
    return Exit.OK


def _board(args: CommandArguments) -> CalibrationBoard:
    from graphnav import CalibrationBoard

    if args.marker_m is not None and not args.charuco:
        raise UserError.of("a checkerboard has no markers", "add --charuco, or leave it out", Place("--marker"))
    marker_m = (args.marker_m or _MARKER_RATIO * args.square_m) if args.charuco else None
    cols, rows = args.board
    return CalibrationBoard(cols, rows, args.square_m, marker_m, args.dictionary)


def _print_board(board: CalibrationBoard, args: CommandArguments) -> int:
    from graphnav.develop.calibrating import print_board

    if args.pictures:
        raise UserError.of("pictures are named too", "print the board first, then calibrate", Place("--print-board"))
    width_m, height_m = print_board(board, args.print_board)
    print(
        f"{args.print_board}: {board.name}, squares of {1e3 * board.square_m:g} mm, a page of "
        f"{1e3 * width_m:.0f} x {1e3 * height_m:.0f} mm"
    )
    print("print it at 100 % (actual size), glue it on something flat, and measure a square")
    return Exit.OK


def _print(found: CameraCalibration, files: CameraFiles) -> None:
    """Print what became of every picture, and the camera."""
    from graphnav.core.tables import Table, print_folded

    rows = [(one.name, one.n_corners, _number(one.rms_px), one.refusal or "used") for one in found.pictures]
    print_folded(Table.plain(("picture", "corners", "rms [px]", "result"), rows, right=("corners", "rms [px]")))
    if found.floor:
        names = ("height [m]", "tilt [deg]", "roll [deg]")
        rows_of_floor = [
            (
                one.name,
                one.n_corners,
                _number(one.height_m, 3),
                _number(one.tilt_deg),
                _number(one.roll_deg),
                one.refusal or "used",
            )
            for one in found.floor
        ]
        header = ("picture of the floor", "corners", *names, "result")
        print_folded(Table.plain(header, rows_of_floor, right=("corners", *names)))
    if found.lens is not None:
        table = Table.plain(("camera", "value", "+-"), list(_camera_rows(found)), right=("value", "+-"))
        print_folded(table)
    written = [files.sheet] if found.problem is not None else list(files)
    print("\n".join(map(str, written)))


def _camera_rows(found: CameraCalibration) -> Iterator[tuple[str, str, str]]:
    lens, mounting, prepared = found.lens, found.mounting, found.prepared
    assert lens is not None
    n_used = sum(not one.refusal for one in found.pictures)
    yield f"pictures used, of {len(found.pictures)}", str(n_used), ""
    yield "reprojection error, rms [px]", f"{lens.rms_px:.3f}", ""
    pixels = {"focal length x": lens.fx_px, "focal length y": lens.fy_px}
    for name, one in {**pixels, "principal point x": lens.cx_px, "principal point y": lens.cy_px}.items():
        yield f"{name} [px]", f"{one.value:.2f}", f"{one.deviation:.2f}"
    for name, one in lens.distortion.items():
        yield f"distortion {name}", f"{one.value:.5f}", f"{one.deviation:.5f}" if one.deviation else "fixed"
    across, down, diagonal = lens.fov_deg
    yield "field of view, across x down [deg]", f"{across:.1f} x {down:.1f}", ""
    yield "field of view, diagonal [deg]", f"{diagonal:.1f}", ""
    yield "picture covered by corners", f"{lens.coverage_ratio:.0%}", ""
    if mounting is not None:
        yield "height above the floor [m]", f"{mounting.height_m.value:.4f}", _number(mounting.height_m.deviation, 4)
        yield "tilt below the horizontal [deg]", f"{mounting.tilt_deg.value:.2f}", _number(mounting.tilt_deg.deviation)
        yield "roll [deg]", f"{mounting.roll_deg.value:.2f}", _number(mounting.roll_deg.deviation)
    if prepared is not None:
        yield "fov_deg of the undistorted picture", f"{prepared.fov_deg:.2f}", ""


def _number(value: float | None, digits: int = 2) -> str:
    return "" if value is None or math.isnan(value) else f"{value:.{digits}f}"


def _as_json(found: CameraCalibration, files: CameraFiles) -> dict[str, Any]:
    def plain(value: Any) -> Any:
        if hasattr(value, "_asdict"):
            return {name: plain(one) for name, one in value._asdict().items()}
        if isinstance(value, dict):
            return {name: plain(one) for name, one in value.items()}
        if isinstance(value, tuple | list):
            return [plain(one) for one in value]
        return None if isinstance(value, float) and math.isnan(value) else value

    told = {name: plain(getattr(found, name)) for name in ("pictures", "floor", "lens", "mounting", "prepared")}
    problem = None if found.problem is None else str(found.problem)
    return {**told, "notices": list(found.notices), "problem": problem, "files": [str(file) for file in files]}
