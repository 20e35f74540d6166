"""Calibration boards: what their corners are, where a picture shows them, and how they are printed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from PIL import Image as Picture

from graphnav import CalibrationBoard, Place, UserError, did_you_mean, written_aside
from graphnav.arrays import Bytes, Doubles, Floats
from graphnav_io.picture_size import MAX_PIXELS
from graphnav_io.quiet import quiet

MIN_CORNERS = 8
"""Of a picture: six tell a homography with a margin, fewer are often misread markers."""
MIN_SPREAD_RATIO = 0.1
"""Of the corners, the shorter extent of their places over the longer one: below it they are on a line."""
EDGE_RATIO = 0.01
"""An edge of the board that is wider than this share of the picture's columns is blurred, but see `MIN_EDGE_PX`."""
MIN_EDGE_PX = 4.0
_PROFILE_RATIO, _SAMPLES = 0.4, 33
"""Edges are sampled over so much of a square to both sides, at so many points."""
PRINT_DPI, INCH_M = 300.0, 0.0254
FLAG = "--print-board"
_DETECT = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
_PART_RATIO = 0.6
"""A part of the board tells why it was not found if it is at least so large; less is often something else."""
_MAX_DETECTED_PX = 2000
"""Boards are looked for in pictures of at most so many columns; corners are then refined in all of it."""


class Fault(NamedTuple):
    """Why a picture is not used: a reason that other pictures may share, and what of this one shows it."""

    reason: str
    detail: str = ""

    def __str__(self) -> str:
        """Return both, for tables."""
        return f"{self.reason}: {self.detail}" if self.detail else self.reason


NO_BOARD = Fault("no board found")
TOO_FEW = "too few corners"


class Corners(NamedTuple):
    """Corners of the board in a picture.

    ``points_px``: (n, 2), column and row, the centre of the first pixel is 0. ``places_m``: (n, 3), on the board.
    ``fault``: why they cannot be used. ``seen``: columns and rows of inner corners of another board that was found.
    """

    points_px: Doubles
    places_m: Doubles
    fault: Fault | None = None
    seen: tuple[int, int] | None = None


NONE = np.empty((0, 2)), np.empty((0, 3))


@dataclass(frozen=True)
class BoardFinder:
    """Finds a board in pictures."""

    board: CalibrationBoard

    def check(self) -> None:
        """Raise UserError for a dictionary that OpenCV does not have, and for markers that do not fit."""
        if self.board.marker_m is not None:
            _ = self.charuco

    def find(self, gray: Bytes) -> Corners:
        """Return the corners in a picture, uint8 (rows, cols)."""
        found = self._checkerboard(gray) if self.board.marker_m is None else self._charuco(gray)
        if found.fault is not None:
            return found
        width, limit = edge_width_px(gray, found, self.board), max(MIN_EDGE_PX, EDGE_RATIO * gray.shape[1])
        if width > limit:
            return found._replace(fault=Fault("blurred", f"its edges are {width:.1f} px wide, more than {limit:.1f}"))
        return found

    @cached_property
    def charuco(self) -> cv2.aruco.CharucoBoard:
        """OpenCV's board."""
        board = self.board
        assert board.marker_m is not None
        if board.marker_m >= board.square_m:
            what = f"a marker of {board.marker_m:g} m is not smaller than a square of {board.square_m:g} m"
            raise UserError.of(what, "measure both on the printed board", Place("--marker"))
        names = sorted(name.removeprefix("DICT_") for name in dir(cv2.aruco) if name.startswith("DICT_"))
        if board.dictionary not in names:
            hint = did_you_mean(board.dictionary, names) or f"use one of {', '.join(names)}"
            raise UserError.of(f"OpenCV has no dictionary '{board.dictionary}'", hint, Place("--dict"))
        markers = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{board.dictionary}"))
        n_markers, n_known = board.cols * board.rows // 2, len(markers.bytesList)
        if n_markers > n_known:
            what = f"the board needs {n_markers} markers, but the dictionary {board.dictionary} has {n_known}"
            raise UserError.of(what, "use a larger one, such as 4X4_250", Place("--dict"))
        return cv2.aruco.CharucoBoard((board.cols, board.rows), board.square_m, board.marker_m, markers)

    @cached_property
    def _detector(self) -> cv2.aruco.CharucoDetector:
        return cv2.aruco.CharucoDetector(self.charuco)

    @cached_property
    def _places_m(self) -> Doubles:
        """All inner corners of a checkerboard, row by row."""
        cols, rows = self.board.cols, self.board.rows
        x, y = np.meshgrid(np.arange(cols), np.arange(rows))
        corners = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
        return np.asarray(corners * self.board.square_m, np.float64)

    def _checkerboard(self, gray: Bytes) -> Corners:
        size = self.board.cols, self.board.rows
        scale = min(1.0, _MAX_DETECTED_PX / max(gray.shape))
        small = gray if scale == 1.0 else cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        with quiet():
            found, points = cv2.findChessboardCornersSB(small, size, flags=_DETECT)
        if not found:
            points, rows, cols = self._part(small)
            if (cols, rows) != size:
                return self._another(rows, cols)
        places = (points.reshape(-1, 2).astype(np.float64) + 0.5) / scale - 0.5
        return Corners(_refined(gray, places, size), self._places_m)

    def _part(self, gray: Bytes) -> tuple[Floats, int, int]:
        """Return the corners of the largest part of any board, row by row, and their rows and columns; 0 without one.

        Now and then it finds all of a board that is not found at once.
        """
        part = max(4, round(_PART_RATIO * self.board.cols)), max(3, round(_PART_RATIO * self.board.rows))
        with quiet():
            found, points, meta = cv2.findChessboardCornersSBWithMeta(gray, part, cv2.CALIB_CB_LARGER | _DETECT)
        return (np.asarray(points, np.float32), *meta.shape[:2]) if found else (np.zeros((0, 1, 2), np.float32), 0, 0)

    def _another(self, rows: int, cols: int) -> Corners:
        """Return the finding in place of the board: nothing, a part of it, or another one."""
        if not rows:
            return Corners(*NONE, NO_BOARD)
        rows, cols = sorted((rows, cols), reverse=self.board.cols < self.board.rows)  # it may lie on its side
        wanted = f"{self.board.cols}x{self.board.rows}"
        if cols > self.board.cols or rows > self.board.rows:
            fault = Fault("another board", f"{cols}x{rows} inner corners, not {wanted}")
        elif (cols, rows) == (self.board.cols, self.board.rows):
            fault = Fault("the board is seen too much from the side, or unsharp")
        else:
            fault = Fault("cut off or covered", f"{cols}x{rows} of {wanted} corners seen")
        return Corners(*NONE, fault, (cols, rows))

    def _charuco(self, gray: Bytes) -> Corners:
        with quiet():
            points, numbers, marked, _ = self._detector.detectBoard(gray)
        if numbers is None or len(numbers) == 0:
            return Corners(*NONE, Fault(TOO_FEW, f"0, of {len(marked)} markers") if marked else NO_BOARD)
        points_px = points.reshape(-1, 2).astype(np.float64)
        places_m = np.asarray(self.charuco.getChessboardCorners(), np.float64)[numbers.reshape(-1)]
        if len(points_px) < MIN_CORNERS:
            return Corners(points_px, places_m, Fault(TOO_FEW, f"{len(points_px)}, but {MIN_CORNERS} are needed"))
        extents = np.linalg.svd(places_m[:, :2] - places_m[:, :2].mean(axis=0), compute_uv=False)
        if extents[1] < MIN_SPREAD_RATIO * extents[0]:
            return Corners(points_px, places_m, Fault(TOO_FEW, "all are on one line"))
        return Corners(points_px, places_m)


def _refined(gray: Bytes, points_px: Doubles, size: tuple[int, int]) -> Doubles:
    """Return corners where the edges around each meet: three times as exact as they were found, in rendered pictures.

    The window reaches less than half as far as the next corner.
    """
    grid = points_px.reshape(size[1], size[0], 2)
    shortest = min(np.linalg.norm(np.diff(grid, axis=axis), axis=-1).min() for axis in (0, 1))
    half = int(np.clip(shortest / 2.5, 2, 15))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 50, 1e-3)
    refined = cv2.cornerSubPix(gray, points_px.astype(np.float32).reshape(-1, 1, 2), (half, half), (-1, -1), stop)
    return np.asarray(refined, np.float64).reshape(-1, 2)


def edge_width_px(gray: Bytes, corners: Corners, board: CalibrationBoard) -> float:
    """Return how wide the edges of the squares are: contrast over the steepest slope, the median over the edges.

    A sharp picture has 1 to 3 pixels.
    """
    reach = _PROFILE_RATIO
    if board.marker_m is not None:  # the white margin of a marker
        reach = 0.9 * (board.square_m - board.marker_m) / 2 / board.square_m
    here, there = _neighbours(corners, board.square_m)
    if not len(here):
        return 0.0
    along = there - here
    across = np.stack([-along[:, 1], along[:, 0]], axis=-1)
    at = np.linspace(-reach, reach, _SAMPLES)
    points = ((here + there) / 2)[:, None] + across[:, None] * at[:, None]
    x, y = np.moveaxis(points, -1, 0).astype(np.float32)
    sampled = cv2.remap(gray, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profiles = np.asarray(sampled, np.float64)
    step_px = np.linalg.norm(along, axis=-1) * (at[1] - at[0])
    contrast = np.abs(profiles[:, -3:].mean(axis=1) - profiles[:, :3].mean(axis=1))
    # over a pixel or more: two samples differ by noise alone
    reached = np.maximum(1, np.ceil(1.0 / step_px)).astype(int)
    steepest = np.array(
        [
            np.abs(line[n:] - line[:-n]).max() / n
            for line, n in zip(profiles, np.minimum(reached, _SAMPLES // 2), strict=True)
        ]
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        widths = np.where(contrast > 0, contrast / steepest * step_px, 0.0)
    return float(np.median(widths))


def _neighbours(corners: Corners, square_m: float) -> tuple[Doubles, Doubles]:
    """Return the two ends, in pixels, of every side of a square."""
    cells = np.rint(corners.places_m[:, :2] / square_m).astype(int)
    index = {(int(col), int(row)): number for number, (col, row) in enumerate(cells)}
    pairs = [
        (number, index[col + right, row + down])
        for (col, row), number in index.items()
        for right, down in ((1, 0), (0, 1))
        if (col + right, row + down) in index
    ]
    here, there = np.array(pairs, int).reshape(-1, 2).T
    return corners.points_px[here], corners.points_px[there]


def print_board(board: CalibrationBoard, file: Path) -> tuple[float, float]:
    """Write a board with a margin of one square, and return the size of the page, metres.

    Raises
    ------
    UserError
        The board is too large, its format is not known, or the file cannot be written.
    """
    if file.suffix.lower() not in (".png", ".pdf"):
        raise UserError.of(f"'{file}' is neither .png nor .pdf", "name it board.pdf or board.png", Place(FLAG))
    per_square = max(1, round(board.square_m / INCH_M * PRINT_DPI))
    n_cols, n_rows = (n + 1 if board.marker_m is None else n for n in (board.cols, board.rows))
    if (n_cols + 2) * (n_rows + 2) * per_square**2 > MAX_PIXELS:
        what = f"a board of {n_cols}x{n_rows} squares of {board.square_m:g} m is larger than a page of 2 x 3 m"
        raise UserError.of(what, "give fewer or smaller squares", Place("--square"))
    if board.marker_m is None:
        odd = np.add.outer(np.arange(n_rows), np.arange(n_cols)) % 2
        squares = (odd * 255).astype(np.uint8).repeat(per_square, axis=0).repeat(per_square, axis=1)
    else:
        squares = BoardFinder(board).charuco.generateImage((n_cols * per_square, n_rows * per_square))
    page = Picture.fromarray(np.pad(squares, per_square, constant_values=255))
    dpi = per_square * INCH_M / board.square_m
    is_pdf = file.suffix.lower() == ".pdf"
    try:
        with written_aside(file) as aside:
            if is_pdf:
                page.convert("1").save(aside, "PDF", resolution=dpi)
            else:
                page.save(aside, "PNG", dpi=(dpi, dpi))
    except OSError as error:
        raise UserError.of(f"cannot write {file}: {error.strerror}", "choose another file", Place(FLAG)) from error
    return page.width / dpi * INCH_M, page.height / dpi * INCH_M
