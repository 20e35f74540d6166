"""Calibrate a camera from pictures of a board: judge the pictures, fit the lens, find the mounting."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from graphnav import (
    BoardPicture,
    CalibrationTask,
    CameraCalibration,
    CameraMounting,
    Estimate,
    FloorPicture,
    LensFit,
    Place,
    PreparedCamera,
    Problem,
)
from graphnav.arrays import Doubles
from graphnav_io.board_pictures import read_shots
from graphnav_io.boards import NONE, BoardFinder, Corners, Fault
from graphnav_io.calibration import calibration_text
from graphnav_io.contact_sheet import Tile, write_sheet
from graphnav_io.floor_mount import MAX_ZOOM, Pose, floor_pose, level_camera, leveling
from graphnav_io.lens import Lens
from graphnav_io.lens_fit import FISHEYE_NAMES, MAX_REFITS, PINHOLE_NAMES, Fit, fit_lens, outlier

PICTURES, FLOOR = "PICTURES", "--floor"
MIN_PICTURES = 8
MIN_TURN_DEG = 15.0
"""Boards that are all parallel to within this do not determine the focal length."""
MAX_FOCAL_RATIO = 0.01
"""The standard deviation of the focal length, as its share: 1 % is a third of a degree of tilt and 1 % of height."""
MAX_RMS_PX, RMS_RATIO = 1.0, 1e-3
"""The reprojection error is at most 1 pixel, or so large a share of the picture's columns."""
SAME_RATIO = 0.01
"""Pictures whose corners differ by less than this share of the columns are of one pose."""
EDGE_RATIO = 0.1
"""Corners should come nearer to every edge of the picture than this share of its size."""
MIN_COVERAGE_RATIO = 0.6
_CELLS = 8, 6
MAX_HEIGHT_RATIO, MAX_ANGLE_DEG = 0.03, 1.5
"""A picture of the floor that differs by more from the median of all was not of that floor."""
MAX_TILT_DEG, MAX_ROLL_DEG = 95.0, 20.0


class Shown(NamedTuple):
    """A picture with the corners that were found; ``small``: of the contact sheet."""

    name: str
    rows: int
    cols: int
    corners: Corners
    tile: Tile


def calibrate(task: CalibrationTask) -> CameraCalibration:
    """Return what the pictures tell of the camera, and write the contact sheet.

    Raises
    ------
    UserError
        The pictures cannot be read, the board cannot exist, or the sheet cannot be written.
    """
    finder = BoardFinder(task.board)
    finder.check()
    result, tiles = _Calibrator(task, _shown(task, finder, PICTURES), _shown(task, finder, FLOOR)).run()
    write_sheet(task.sheet, tiles)
    return result


def _shown(task: CalibrationTask, finder: BoardFinder, option: str) -> list[Shown]:
    found = []
    for name, gray, fault in read_shots(task.pictures if option == PICTURES else task.floor, option):
        corners = finder.find(gray) if fault is None else Corners(*NONE, fault)
        rows, cols = gray.shape
        found.append(Shown(name, rows, cols, corners, Tile.of(name, gray, corners.points_px)))
    return found


class _Calibrator:
    """One calibration: the pictures, and what becomes of each."""

    def __init__(self, task: CalibrationTask, pictures: list[Shown], floor: list[Shown]) -> None:
        self._task, self._pictures, self._floor = task, pictures, floor
        self._refusals: dict[int, Fault] = {}
        self._errors_px: dict[int, float] = {}
        self._floor_rows: list[FloorPicture] = []
        self._notices: list[str] = []
        sizes = Counter((one.rows, one.cols) for one in pictures if one.rows)
        self._rows, self._cols = sizes.most_common(1)[0][0] if sizes else (0, 0)

    def run(self) -> tuple[CameraCalibration, list[Tile]]:
        """Return the calibration, and the tiles of the contact sheet."""
        self._judge()
        fit, problem = self._fitted()
        lens = None if fit is None else self._lens_fit(fit)
        mounting = prepared = None
        text = ""
        if fit is not None and problem is None:
            mounting, problem = self._mounting(fit.lens)
        if fit is not None and problem is None:
            prepared, text, problem = self._prepared(fit.lens, mounting)
        rows = tuple(
            BoardPicture(one.name, len(one.corners.points_px), self._errors_px.get(n), str(self._refusals.get(n, "")))
            for n, one in enumerate(self._pictures)
        )
        tiles = [one.tile.judged(row.refusal) for one, row in zip(self._pictures, rows, strict=True)]
        floor = self._floor_rows or [self._unused(one) for one in self._floor]
        tiles += [one.tile.judged(row.refusal, "floor: ") for one, row in zip(self._floor, floor, strict=True)]
        found = CameraCalibration(rows, tuple(floor), lens, mounting, prepared, text, tuple(self._notices), problem)
        return found, tiles

    def _judge(self) -> None:
        """Refuse pictures by themselves, and those of the pose of an earlier one."""
        kept: list[Corners] = []
        for number, one in enumerate(self._pictures):
            fault = self._fault(one) or self._same_pose(one.corners, kept)
            if fault is None:
                kept.append(one.corners)
            else:
                self._refusals[number] = fault

    def _fault(self, one: Shown) -> Fault | None:
        if one.rows and (one.rows, one.cols) != (self._rows, self._cols):
            return Fault(f"has {one.cols}x{one.rows} pixels, but most have {self._cols}x{self._rows}")
        return one.corners.fault

    def _same_pose(self, corners: Corners, others: Sequence[Corners]) -> Fault | None:
        for other in others:
            if len(other.points_px) == len(corners.points_px) and (other.places_m == corners.places_m).all():
                moved_px = float(np.linalg.norm(other.points_px - corners.points_px, axis=1).mean())
                if moved_px < SAME_RATIO * self._cols:
                    return Fault("same pose as another", f"its corners moved by {moved_px:.1f} px")
        return None

    @property
    def _used(self) -> list[int]:
        return [number for number in range(len(self._pictures)) if number not in self._refusals]

    def _fitted(self) -> tuple[Fit | None, Problem | None]:
        """Return the lens, and what is wrong with it."""
        if problem := self._too_few():
            return None, problem
        n_left_out = 0
        while True:
            used = self._used
            try:
                fit = fit_lens(
                    [self._pictures[n].corners for n in used], self._rows, self._cols, is_fisheye=self._task.is_fisheye
                )
            except ValueError:
                hint = "take pictures in which the board fills more of the picture, tilted by 20 to 45 degrees"
                return None, _problem("OpenCV finds no lens that fits the corners", hint)
            self._errors_px |= dict(zip(used, fit.picture_px.tolist(), strict=True))
            worst = outlier(fit) if len(used) > MIN_PICTURES and n_left_out < MAX_REFITS else None
            if worst is None:
                return fit, self._undetermined(fit)
            detail = f"{fit.picture_px[worst]:.1f} px off, the board moved or is bent"
            self._refusals[used[worst]] = Fault("does not fit the others", detail)
            n_left_out += 1

    def _too_few(self) -> Problem | None:
        n_used, n_all = len(self._used), len(self._pictures)
        if n_used >= MIN_PICTURES:
            return None
        seen = Counter(one.corners.seen for one in self._pictures if one.corners.seen is not None)
        board = self._task.board
        if seen and board.marker_m is None and not n_used:
            (cols, rows), n_seen = seen.most_common(1)[0]
            if n_seen > n_all / 2:
                what = f"{n_seen} of {n_all} pictures show {cols}x{rows} inner corners, not {board.cols}x{board.rows}"
                return _problem(what, f"give --board {cols}x{rows}", "--board")
        what = f"{n_used} of {n_all} pictures can be used, but {MIN_PICTURES} are needed"
        reasons = Counter(fault.reason for fault in self._refusals.values())
        told = ", ".join(f"{n} {reason}" for reason, n in reasons.most_common(3))
        return _problem(f"{what} ({told})" if told else what, "take 20 with the complete board, each from another side")

    def _undetermined(self, fit: Fit) -> Problem | None:
        """Return why the pictures do not determine the lens."""
        fx, deviation = fit.lens.camera[0, 0], fit.deviations[0]
        turn = "turn the board by 20 to 45 degrees to left, right, up and down in half of the pictures"
        if fit.turned_deg < MIN_TURN_DEG:
            what = f"the boards of all pictures are parallel, within {fit.turned_deg:.0f} degrees: no focal length"
            return _problem(f"{what} ({fx:.0f} +- {deviation:.0f} px)", turn)
        if fit.rms_px > (limit := max(MAX_RMS_PX, RMS_RATIO * self._cols)):
            what = f"the corners are {fit.rms_px:.2f} px off where the lens would show them, more than {limit:.2f}"
            hint = "use a flat board that lies still"
            return _problem(what, hint if self._task.is_fisheye else f"{hint}; for a fisheye lens add --fisheye")
        if not fit.focal_ratio <= MAX_FOCAL_RATIO:
            what = f"the focal length is not determined: {fx:.0f} +- {deviation:.0f} px"
            return _problem(what, f"{turn}, and fill the picture with it")
        return None

    def _lens_fit(self, fit: Fit) -> LensFit:
        (fx, _, cx), (_, fy, cy), _ = fit.lens.camera.tolist()
        sd = fit.deviations.tolist()
        names = FISHEYE_NAMES if fit.lens.is_fisheye else PINHOLE_NAMES
        values = zip(names, fit.lens.distortion.tolist(), sd[4:], strict=True)
        distortion = {name: Estimate(value, deviation) for name, value, deviation in values}
        points = np.concatenate([self._pictures[n].corners.points_px for n in self._used])
        self._notices += self._uncovered(points)
        view = _fov_deg(fit.lens, self._rows, self._cols)
        share = self._coverage(points)
        return LensFit(
            self._cols,
            self._rows,
            Estimate(fx, sd[0]),
            Estimate(fy, sd[1]),
            Estimate(cx, sd[2]),
            Estimate(cy, sd[3]),
            distortion,
            fit.lens.is_fisheye,
            fit.rms_px,
            view,
            share,
        )

    def _coverage(self, points: Doubles) -> float:
        cells, _, _ = np.histogram2d(
            points[:, 0], points[:, 1], bins=_CELLS, range=((-0.5, self._cols - 0.5), (-0.5, self._rows - 0.5))
        )
        return float((cells > 0).mean())

    def _uncovered(self, points: Doubles) -> Iterator[str]:
        """Yield which edges of the picture no corner comes near, and how much of it holds none."""
        size = np.array([self._cols, self._rows], float)
        low, high = points.min(axis=0) / size, 1 - points.max(axis=0) / size
        ends = {"left": low[0], "right": high[0], "upper": low[1], "lower": high[1]}
        far = [f"{name} ({ratio:.0%})" for name, ratio in ends.items() if ratio > EDGE_RATIO]
        if far:
            yield f"no corner comes near an edge of the picture: {', '.join(far)}; distortion there is extrapolated"
        if (share := self._coverage(points)) < MIN_COVERAGE_RATIO:
            yield f"corners are in {share:.0%} of the picture only: show the board in its corners and at its edges too"

    def _mounting(self, lens: Lens) -> tuple[CameraMounting | None, Problem | None]:
        """Return the median over the pictures of the floor, once those that differ from it are refused."""
        if not self._floor:
            return None, None
        poses: dict[int, Pose] = {}
        faults: dict[int, str] = {}
        for number, one in enumerate(self._floor):
            if (fault := self._fault(one)) is not None:
                faults[number] = str(fault)
                continue
            try:
                poses[number] = floor_pose(one.corners, lens, self._task.rotate_deg // 90)
            except ValueError as error:
                faults[number] = str(error)
        median = _median(list(poses.values()))
        for number, pose in poses.items():
            if off := _off_floor(pose, median):
                faults[number] = off
        for number, one in enumerate(self._floor):
            pose = poses.get(number, Pose(math.nan, math.nan, math.nan))
            angles = math.degrees(pose.tilt_rad), math.degrees(pose.roll_rad)
            row = FloorPicture(one.name, len(one.corners.points_px), pose.height_m, *angles, faults.get(number, ""))
            self._floor_rows.append(row)
        kept = [pose for number, pose in poses.items() if number not in faults]
        if problem := self._no_floor(poses, kept):
            return None, problem
        if len(kept) == 1:
            self._notices.append("one picture of the floor tells no spread: take 3 to 5, the board in other places")
        return _spread(kept), None

    def _no_floor(self, poses: dict[int, Pose], kept: Sequence[Pose]) -> Problem | None:
        if not poses:
            what = f"none of {len(self._floor)} pictures of the floor shows the board"
            return _problem(what, "lay it where the camera sees all of it, with light from the side", FLOOR)
        if 2 * len(kept) <= len(poses):
            heights = [pose.height_m for pose in poses.values()]
            what = f"the pictures of the floor do not agree: heights from {min(heights):.3f} to {max(heights):.3f} m"
            return _problem(what, "leave the camera on the robot, and lay the board flat on one level floor", FLOOR)
        middle = _median(kept)
        tilt_deg, roll_deg = math.degrees(middle.tilt_rad), math.degrees(middle.roll_rad)
        if not 0.0 < tilt_deg <= MAX_TILT_DEG or abs(roll_deg) > MAX_ROLL_DEG:
            what = f"the camera has a tilt of {tilt_deg:.0f} and a roll of {roll_deg:.0f} degrees"
            hint = "say with --rotate 90, 180 or 270 how its pictures are turned until the robot's front is up"
            return _problem(what, hint, FLOOR)
        return None

    def _prepared(
        self, lens: Lens, mounting: CameraMounting | None
    ) -> tuple[PreparedCamera | None, str, Problem | None]:
        """Return the camera of the level picture, and the file that says how it is made."""
        turns = self._task.rotate_deg // 90
        level, height_m, tilt_deg = np.eye(3), None, None
        if mounting is not None:
            pose = Pose(
                mounting.height_m.value, math.radians(mounting.tilt_deg.value), math.radians(mounting.roll_deg.value)
            )
            height_m, tilt_deg = pose.height_m, min(mounting.tilt_deg.value, 90.0)
            level = leveling(pose, tilt_deg, turns)
        camera = level_camera(lens, level, self._rows, self._cols)
        if camera is None:
            roll_deg = 0.0 if mounting is None else mounting.roll_deg.value
            longer = f"more than {MAX_ZOOM:g} times the focal length"
            what = f"the level picture needs {longer}, at a roll of {roll_deg:.0f} degrees"
            return None, "", _problem(what, "mount the camera level", FLOOR)
        cols, rows = (self._rows, self._cols) if turns % 2 else (self._cols, self._rows)
        fov_deg = 2 * math.degrees(math.atan(cols / 2 / camera[0, 0]))
        text = calibration_text(lens, self._rows, self._cols, level, camera)
        return PreparedCamera(cols, rows, fov_deg, height_m, tilt_deg), text, None

    def _unused(self, one: Shown) -> FloorPicture:
        unknown = math.nan, math.nan, math.nan
        return FloorPicture(
            one.name, len(one.corners.points_px), *unknown, str(self._fault(one) or "the lens is not known")
        )


def _problem(what: str, hint: str, option: str = PICTURES) -> Problem:
    return Problem(Place(option), what, hint)


def _median(poses: Sequence[Pose]) -> Pose:
    return Pose(*np.median(np.array(poses), axis=0).tolist()) if poses else Pose(math.nan, math.nan, math.nan)


def _off_floor(pose: Pose, median: Pose) -> str:
    tilt, roll = (math.degrees(a - b) for a, b in zip(pose[1:], median[1:], strict=True))
    if abs(pose.height_m / median.height_m - 1) > MAX_HEIGHT_RATIO:
        return f"not on the floor of the others: {pose.height_m:.3f} m below the camera, they {median.height_m:.3f} m"
    if max(abs(tilt), abs(roll)) > MAX_ANGLE_DEG:
        return f"not on the floor of the others: tilt {tilt:+.1f}, roll {roll:+.1f} degrees from theirs"
    return ""


def _spread(poses: Sequence[Pose]) -> CameraMounting:
    middle, many = _median(poses), np.array(poses)
    sd = many.std(axis=0, ddof=1) if len(poses) > 1 else np.full(3, np.nan)
    return CameraMounting(
        Estimate(middle.height_m, float(sd[0])),
        Estimate(math.degrees(middle.tilt_rad), math.degrees(sd[1])),
        Estimate(math.degrees(middle.roll_rad), math.degrees(sd[2])),
    )


def _fov_deg(lens: Lens, rows: int, cols: int) -> tuple[float, float, float]:
    """Return what the picture shows through the lens: across and down through its middle, corner to corner."""
    right, low, cx, cy = cols - 0.5, rows - 0.5, (cols - 1) / 2, (rows - 1) / 2
    ends = [(-0.5, cy), (right, cy), (cx, -0.5), (cx, low), (-0.5, -0.5), (right, low)]
    rays = np.column_stack([lens.rays(np.array(ends)), np.ones(6)])
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    across, down, diagonal = (
        math.degrees(math.acos(float(np.clip(rays[k] @ rays[k + 1], -1.0, 1.0)))) for k in (0, 2, 4)
    )
    return across, down, diagonal
