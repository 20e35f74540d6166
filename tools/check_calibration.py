"""Check ``graphnav calibrate`` against cameras that are known exactly, and tell by how much it is off.

``python tools/check_calibration.py`` renders boards through several lenses, from several seeds, with noise and blur,
and prints the errors of focal length, height, tilt and roll beside their targets, and what it says of bad pictures. The
exit status is 1 where a target is missed. ``--study FOLDER`` also writes the camera of the study ``calibration``:
the true one and the calibrated one.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from graphnav_io.calibrate import calibrate
from graphnav_io.calibration import calibration_text
from graphnav_io.floor_mount import Pose, level_camera, leveling
from graphnav_io.lens import Lens
from testbed.rendered_board import BoardCamera

from graphnav import CalibrationBoard, CalibrationTask, CameraCalibration, Mount
from graphnav.arrays import Bytes, Doubles
from graphnav.core.tables import Table, print_folded

MAX_FOCAL_RATIO, MAX_HEIGHT_RATIO, MAX_TILT_DEG = 0.01, 0.02, 0.5
CHECKERED = CalibrationBoard(9, 6, 0.03)
COARSE = CalibrationBoard(6, 4, 0.06)
CHARUCO = CalibrationBoard(8, 6, 0.05, 0.037)
N_PICTURES = 20


def pinhole(rows: int, cols: int, fov_deg: float, distortion: Sequence[float], off_px: tuple[float, float]) -> Lens:
    """Return a lens; ``off_px``: from the middle of the picture to the principal point."""
    matrix = Mount(1.0, 75.0, fov_deg, 0.0).intrinsics(rows, cols)
    matrix[:2, 2] += off_px
    coefficients = np.zeros(5)
    coefficients[: len(distortion)] = distortion
    return Lens(matrix, coefficients, is_fisheye=False)


def fisheye(rows: int, cols: int, focal_px: float) -> Lens:
    """Return a fisheye lens."""
    matrix = np.array([[focal_px, 0.0, (cols - 1) / 2 + 3], [0.0, focal_px, (rows - 1) / 2 - 2], [0.0, 0.0, 1.0]])
    return Lens(matrix, np.array([-0.02, 0.005, -0.002, 0.0]), is_fisheye=True)


CAMERAS = {
    "70 deg, barrel": BoardCamera(
        pinhole(480, 640, 70, (-0.25, 0.07, 0.001, -5e-4), (5, -4)), 480, 640, CHECKERED, 4, 0.7
    ),
    "90 deg, barrel": BoardCamera(pinhole(480, 640, 90, (-0.2, 0.04), (-6, 3)), 480, 640, CHECKERED, 4, 0.7),
    "45 deg, blurred": BoardCamera(pinhole(480, 640, 45, (-0.05,), (2, 2)), 480, 640, CHECKERED, 6, 1.2),
    "160x120, 70 deg": BoardCamera(pinhole(120, 160, 70, (-0.2, 0.04), (0, 0)), 120, 160, COARSE, 2, 0.4),
    "70 deg, ChArUco": BoardCamera(pinhole(480, 640, 70, (-0.25, 0.07), (5, -4)), 480, 640, CHARUCO, 4, 0.7),
    "fisheye": BoardCamera(fisheye(480, 640, 280.0), 480, 640, CHECKERED, 4, 0.7),
}
MOUNTS = (Mount(0.9, 72.0, 70.0, 0.0), Mount(0.6, 55.0, 70.0, 0.0), Mount(1.2, 85.0, 70.0, 0.0))
ROLLS_DEG = 2.0, -1.5, 1.0
STUDY_CAMERA = BoardCamera(pinhole(120, 160, 70, (-0.2, 0.04), (0, 0)), 120, 160, COARSE, 2, 0.4)


def hand_pictures(camera: BoardCamera, rng: np.random.Generator, n_pictures: int = N_PICTURES) -> Iterator[Bytes]:
    """Yield pictures of a board that is held by hand."""
    for _ in range(n_pictures):
        yield camera.picture(camera.hand_pose(rng), rng)


def floor_pictures(camera: BoardCamera, mount: Mount, roll_deg: float, rng: np.random.Generator) -> Iterator[Bytes]:
    """Yield three pictures of a board on the floor, at other places and turned."""
    for across, yaw_deg in ((0.5, -10.0), (0.35, 25.0), (0.6, 70.0)):
        pixel = across * camera.cols, 0.5 * camera.rows
        yield camera.picture(camera.floor_pose(mount, roll_deg, pixel, yaw_deg), rng)


def calibration_of(
    camera: BoardCamera, pictures: Sequence[Bytes], floor: Sequence[Bytes], folder: Path
) -> CameraCalibration:
    """Return what ``graphnav calibrate`` makes of pictures, written into a folder."""
    for name, many in (("pictures", pictures), ("floor", floor)):
        (folder / name).mkdir(parents=True, exist_ok=True)
        for number, gray in enumerate(many):
            cv2.imwrite(str(folder / name / f"{number}.png"), gray)
    on_floor = (folder / "floor",) if floor else ()
    sheet = folder / "sheet.png"
    task = CalibrationTask((folder / "pictures",), on_floor, camera.board, sheet, is_fisheye=camera.lens.is_fisheye)
    return calibrate(task)


def check(seeds: Sequence[int], folder: Path) -> bool:
    """Print the errors of every camera, and return whether all are within their targets."""
    rows, is_fine = [], True
    for name, camera in CAMERAS.items():
        for seed in seeds:
            rng = np.random.default_rng(seed)
            mount, roll_deg = MOUNTS[seed % len(MOUNTS)], ROLLS_DEG[seed % len(ROLLS_DEG)]
            pictures = list(hand_pictures(camera, rng))
            floor = list(floor_pictures(camera, mount, roll_deg, rng))
            found = calibration_of(camera, pictures, floor, folder / f"{name} {seed}")
            if found.lens is None or found.mounting is None:
                rows.append((name, seed, str(found.problem), "", "", "", "", ""))
                is_fine = False
                continue
            true = camera.lens.camera
            focal = max(abs(found.lens.fx_px.value / true[0, 0] - 1), abs(found.lens.fy_px.value / true[1, 1] - 1))
            center = np.hypot(found.lens.cx_px.value - true[0, 2], found.lens.cy_px.value - true[1, 2])
            height = found.mounting.height_m.value / mount.height_m - 1
            tilt, roll = found.mounting.tilt_deg.value - mount.tilt_deg, found.mounting.roll_deg.value - roll_deg
            is_fine &= focal <= MAX_FOCAL_RATIO and abs(height) <= MAX_HEIGHT_RATIO and abs(tilt) <= MAX_TILT_DEG
            used = sum(not one.refusal for one in found.pictures)
            numbers = f"{focal:.2%}", f"{center:.2f}", f"{height:+.2%}", f"{tilt:+.3f}", f"{roll:+.3f}"
            rows.append((name, seed, f"{used}/{len(found.pictures)}, {camera.board.square_m:g} m", *numbers))
            print(*rows[-1], flush=True)
    header = ("camera", "seed", "used", "focal", "centre [px]", "height", "tilt [deg]", "roll [deg]")
    print_folded(Table.plain(header, rows, right=header[3:]))
    print(f"targets: focal {MAX_FOCAL_RATIO:.0%}, height {MAX_HEIGHT_RATIO:.0%}, tilt {MAX_TILT_DEG} deg: ", end="")
    print("met" if is_fine else "MISSED")
    return is_fine


def bad_pictures(camera: BoardCamera, rng: np.random.Generator) -> dict[str, Bytes]:
    """Return pictures that must be refused, by what is wrong with them."""
    middle, depth = (camera.cols / 2, camera.rows / 2), 0.03 * 12 * camera.lens.camera[0, 0] / camera.cols * 1.5
    plain = camera.pose_at(middle, depth, (20.0, 10.0, 5.0))
    cut = camera.pose_at((0.9 * camera.cols, middle[1]), depth, (0.0, 0.0, 0.0))
    other = replace(camera, board=CalibrationBoard(7, 5, 0.03))
    small = camera.picture(plain, rng)[::2, ::2]
    return {
        "no board": rng.integers(100, 150, (camera.rows, camera.cols)).astype(np.uint8),
        "blurred": replace(camera, blur_px=5.0).picture(plain, rng),
        "first": camera.picture(plain, rng),
        "same": camera.picture(plain, rng),
        "cut off": camera.picture(cut, rng),
        "another board": other.picture(other.pose_at(middle, depth, (10.0, 0.0, 0.0)), rng),
        "another size": np.ascontiguousarray(small),
    }


def check_bad(folder: Path) -> None:
    """Print the refusals of bad pictures, and of sets that determine nothing."""
    camera, rng = CAMERAS["70 deg, barrel"], np.random.default_rng(5)
    bad = bad_pictures(camera, rng)
    found = calibration_of(camera, [*hand_pictures(camera, rng, 12), *bad.values()], (), folder / "bad")
    refusals = {one.name: one.refusal for one in found.pictures}
    rows = [(name, refusals[f"{number}.png"] or "used") for number, name in enumerate(bad, 12)]
    print_folded(Table.plain(("picture", "result"), rows))
    flat = []
    for share in np.linspace(0.35, 0.65, 10):
        pose = camera.pose_at((share * camera.cols, share * camera.rows), 0.5 + share, (0.0, 0.0, 10 * share))
        flat.append(camera.picture(pose, rng))
    print("all parallel:", calibration_of(camera, flat, (), folder / "flat").problem)
    print("too few:", calibration_of(camera, flat[:3], (), folder / "few").problem)


def text_of(lens: Lens, level: Doubles, camera: BoardCamera) -> str:
    """Return the calibration's file of a lens that is known."""
    projection = level_camera(lens, level, camera.rows, camera.cols)
    assert projection is not None
    return calibration_text(lens, camera.rows, camera.cols, level, projection)


def write_study(folder: Path) -> None:
    """Write the calibrations of the study's camera, and print its mounting."""
    camera, mount, roll_deg, rng = STUDY_CAMERA, MOUNTS[0], ROLLS_DEG[0], np.random.default_rng(7)
    with tempfile.TemporaryDirectory() as scratch:
        pictures, floor = list(hand_pictures(camera, rng, 30)), list(floor_pictures(camera, mount, roll_deg, rng))
        found = calibration_of(camera, pictures, floor, Path(scratch))
    pose = Pose(mount.height_m, np.radians(mount.tilt_deg), np.radians(roll_deg))
    (folder / "lens_true.yml").write_text(text_of(camera.lens, leveling(pose, mount.tilt_deg, 0), camera))
    (folder / "lens_calibrated.yml").write_text(found.text)
    print(found.lens, found.mounting, found.prepared, found.problem, sep="\n")


def main() -> int:
    """Run the checks."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=3, help="seeds of each camera (default: %(default)s)")
    parser.add_argument("--study", type=Path, metavar="FOLDER", help="write the camera of the study into this folder")
    parser.add_argument("-o", type=Path, metavar="FOLDER", help="keep the pictures there")
    args = parser.parse_args()
    if args.study is not None:
        write_study(args.study)
        return 0
    with tempfile.TemporaryDirectory() as scratch:
        folder = args.o or Path(scratch)
        is_fine = check(range(args.seeds), folder)
        check_bad(folder)
    return 0 if is_fine else 1


if __name__ == "__main__":
    sys.exit(main())
