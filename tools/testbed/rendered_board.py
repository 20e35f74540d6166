"""Pictures of a calibration board through a camera that is known exactly: pixels are rays, met by the board's plane.

Nothing is warped: every pixel is undistorted, which is iterated until it is exact, cast onto the plane, and takes the
brightness there. The edges of a checkerboard are ramps of a pixel; a ChArUco board's pixels are means of samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from graphnav_io.boards import BoardFinder
from graphnav_io.lens import Lens

from graphnav import CalibrationBoard, Mount
from graphnav.arrays import Bytes, Doubles, Floats

BLACK, WHITE, AROUND = 30.0, 215.0, 140.0
FAR = 1e4
"""Where a ray that does not meet the board's plane is taken to meet it, in squares."""
SAMPLES = 3
"""The pixels of a ChArUco board are means of so many squared."""
_SQUARE_PX = 40
"""Of a ChArUco board's picture, from which samples are taken."""


@dataclass(frozen=True)
class BoardPose:
    """The rotation (3, 3) from the board to the camera, and the board's origin in the camera's frame, metres."""

    rotation: Doubles
    place_m: Doubles


@dataclass(frozen=True, eq=False)
class BoardCamera:
    """A camera that takes pictures of a board.

    ``noise_gray``: standard deviation; ``blur_px``: standard deviation of a Gaussian.
    """

    lens: Lens
    rows: int
    cols: int
    board: CalibrationBoard
    noise_gray: float = 0.0
    blur_px: float = 0.0

    def picture(self, pose: BoardPose, rng: np.random.Generator) -> Bytes:
        """Return a picture of the board, uint8 (rows, cols)."""
        rays = self._rays @ pose.rotation.astype(np.float32)  # in the frame of the board, as the camera's centre is
        eye = -pose.rotation.T @ pose.place_m
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = -eye[2] / rays[..., 2]
            points = (eye[:2] + reach[..., None] * rays[..., :2]) / self.board.square_m
        points[~(reach > 0)] = FAR
        gray = self._charuco(points) if self.board.marker_m is not None else self._checkered(points)
        if self.blur_px:
            gray = cv2.GaussianBlur(gray, (0, 0), self.blur_px, borderType=cv2.BORDER_REPLICATE)
        noisy = gray + rng.normal(0.0, self.noise_gray, gray.shape)
        return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)

    @property
    def origin_m(self) -> Doubles:
        """The middle of the board in its frame, whose origin is the corner that OpenCV takes."""
        cols, rows = self.board.cols, self.board.rows
        less = 1 if self.board.marker_m is None else 0
        return np.array([(cols - less) / 2, (rows - less) / 2, 0.0]) * self.board.square_m

    def pose_at(self, pixel: tuple[float, float], depth_m: float, turns_deg: tuple[float, float, float]) -> BoardPose:
        """Return the pose of a board whose middle is seen at a pixel: turned about the camera's x, y and z."""
        about = [cv2.Rodrigues(np.radians(angle) * axis)[0] for angle, axis in zip(turns_deg, np.eye(3), strict=True)]
        rotation = about[0] @ about[1] @ about[2]
        x, y = self.lens.rays(np.array([pixel]))[0]
        return BoardPose(rotation, np.array([x, y, 1.0]) * depth_m - rotation @ self.origin_m)

    def hand_pose(self, rng: np.random.Generator) -> BoardPose:
        """Return a pose of a board that is held by hand: anywhere in the picture, turned by up to 45 degrees."""
        size = np.array([self.board.cols, self.board.rows]).max() * self.board.square_m
        fills = rng.uniform(0.35, 0.7)
        depth = size * self.lens.camera[0, 0] / (fills * self.cols)
        reach = 0.5 - 0.42 * fills
        shares = 0.5 + rng.uniform(-1, 1, 2) * reach * np.array([1.0, self.rows / self.cols])
        turned = rng.uniform(-45, 45, 2)
        return self.pose_at((shares[0] * self.cols, shares[1] * self.rows), depth, (*turned, rng.uniform(-20, 20)))

    def floor_pose(self, mount: Mount, roll_deg: float, pixel: tuple[float, float], yaw_deg: float) -> BoardPose:
        """Return the pose of a board on the floor, its middle seen at a pixel; ``roll_deg``: of the camera."""
        c, s = math.cos(math.radians(roll_deg)), math.sin(math.radians(roll_deg))
        R_CR = mount.R_CR @ np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])
        ray = R_CR.T @ np.array([*self.lens.rays(np.array([pixel]))[0], 1.0])
        place = R_CR @ (ray * mount.height_m / -ray[2])
        turn = cv2.Rodrigues(np.array([0.0, 0.0, math.radians(yaw_deg)]))[0]
        # seen from above the board's z points down, as it points away from a camera that faces the board
        rotation = R_CR @ turn @ np.diag([1.0, -1.0, -1.0])
        return BoardPose(rotation, place - rotation @ self.origin_m)

    @property
    def _samples(self) -> int:
        return 1 if self.board.marker_m is None else SAMPLES

    @cached_property
    def _rays(self) -> Floats:
        n = self._samples
        x, y = ((np.arange(many * n) + 0.5) / n - 0.5 for many in (self.cols, self.rows))
        pixels = np.stack(np.meshgrid(x, y), axis=-1)
        flat = self.lens.rays(pixels.reshape(-1, 2)).reshape(pixels.shape)
        return np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=-1).astype(np.float32)

    def _checkered(self, points: Floats) -> Floats:
        """Return the brightness of points in units of squares, one of each pixel: edges are as wide as a pixel."""
        cols, rows = self.board.cols, self.board.rows
        edges = []
        for k, n in ((0, cols), (1, rows)):
            width = np.hypot(*np.gradient(points[..., k])) + 1e-9
            inside = np.clip((np.minimum(points[..., k] + 1, n - points[..., k])) / width + 0.5, 0, 1)
            paper = np.clip((np.minimum(points[..., k] + 2, n + 1 - points[..., k])) / width + 0.5, 0, 1)
            line = np.clip(np.rint(points[..., k]), 0, n - 1)
            side = np.clip(2 * (points[..., k] - line) / width, -1, 1) * (1 - 2 * (line % 2))
            edges.append((inside, paper, side))
        (inside_x, paper_x, x), (inside_y, paper_y, y) = edges
        squares = (WHITE + BLACK) / 2 - x * y * (WHITE - BLACK) / 2
        inside, paper = inside_x * inside_y, paper_x * paper_y
        return np.asarray(AROUND + paper * (WHITE + inside * (squares - WHITE) - AROUND), np.float32)

    def _charuco(self, points: Floats) -> Floats:
        """Return the mean brightness of the samples of each pixel, of points in units of squares."""
        cols, rows, n = self.board.cols, self.board.rows, SAMPLES
        at = np.floor(points * _SQUARE_PX).astype(int)
        inside = (at >= 0).all(axis=-1) & (at[..., 0] < cols * _SQUARE_PX) & (at[..., 1] < rows * _SQUARE_PX)
        found = self._squares[np.where(inside, at[..., 1], 0), np.where(inside, at[..., 0], 0)]
        paper = (points >= -1).all(axis=-1) & (points[..., 0] < cols + 1) & (points[..., 1] < rows + 1)
        gray = np.where(inside, np.where(found > 127, WHITE, BLACK), np.where(paper, WHITE, AROUND))
        return np.asarray(gray.reshape(self.rows, n, self.cols, n).mean(axis=(1, 3)), np.float32)

    @cached_property
    def _squares(self) -> Bytes:
        cols, rows = self.board.cols, self.board.rows
        picture: Bytes = BoardFinder(self.board).charuco.generateImage((cols * _SQUARE_PX, rows * _SQUARE_PX))
        return picture
