"""The camera's tiles of the video: picture with the control force, flow, dominant plane, potential."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from graphnav import Flow, Image, Plane, Potential, Steering
from graphnav.arrays import Bytes
from graphnav_view import style
from graphnav_view.flow_colour import flow_rgb, wheel_rgb
from graphnav_view.video.lettering import write

_WHEEL_PX = 64
_BLANK = 60
_STRIPE_PX = 10


class Stretch:
    """Fits grids of one camera into tiles of one size, keeping their shape."""

    def __init__(self, picture_rows: int, picture_cols: int, tile_rows: int, tile_cols: int) -> None:
        scale = min(tile_rows / picture_rows, tile_cols / picture_cols)
        self.rows, self.cols = max(1, round(picture_rows * scale)), max(1, round(picture_cols * scale))
        self.top, self.left = (tile_rows - self.rows) // 2, (tile_cols - self.cols) // 2
        self.per_px = scale
        self._tile = (tile_rows, tile_cols)

    @property
    def tile_size_px(self) -> tuple[int, int]:
        """Columns and rows of a tile."""
        rows, cols = self._tile
        return cols, rows

    def blank(self) -> Bytes:
        """Return an empty tile, (rows, cols, 3)."""
        return np.full((*self._tile, 3), _BLANK, np.uint8)

    def resized(self, grid: npt.NDArray[Any], step_px: int, interpolation: int = cv2.INTER_NEAREST) -> npt.NDArray[Any]:
        """Return a grid of step ``step_px`` resized to the picture in the tile."""
        rows, cols = grid.shape[:2]
        covered = (max(1, round(cols * step_px * self.per_px)), max(1, round(rows * step_px * self.per_px)))
        large = cv2.resize(np.ascontiguousarray(grid), covered, interpolation=interpolation)[: self.rows, : self.cols]
        short = ((0, self.rows - large.shape[0]), (0, self.cols - large.shape[1]), (0, 0))[: grid.ndim]
        return np.pad(large, short, mode="edge") if any(after for _, after in short) else large

    def placed(self, picture: Bytes) -> Bytes:
        """Return a tile with the resized ``picture``, (rows, cols, 3), in its middle."""
        tile = self.blank()
        tile[self.top : self.top + self.rows, self.left : self.left + self.cols] = picture
        return tile


def camera_rgb(stretch: Stretch, image: Image) -> Bytes:
    """Return the picture at the tile's size, (rows, cols, 3)."""
    pixels = image.pixels if image.pixels.ndim == 3 else cv2.cvtColor(image.pixels, cv2.COLOR_GRAY2RGB)
    is_reduced = stretch.per_px * image.step_px < 1
    interpolation = cv2.INTER_AREA if is_reduced else cv2.INTER_LINEAR
    return np.asarray(stretch.resized(pixels, image.step_px, interpolation), np.uint8)


def camera_tile(stretch: Stretch, camera: Bytes, steering: Steering | None, width_px: int = 4) -> Bytes:
    """Return the camera's tile, with the control force from the picture's middle, ``width_px`` wide."""
    tile = stretch.placed(camera)
    if steering is not None:
        size = min(stretch.rows, stretch.cols)
        length = float(np.hypot(*steering.control))
        start = np.array([stretch.left + stretch.cols / 2, stretch.top + stretch.rows / 2])
        end = start + np.array([1.0, -1.0]) * steering.control / max(length, 1.0) * 0.38 * size
        for colour, width in (((0, 0, 0), width_px + 3), (style.rgb(style.CONTROL), width_px)):
            cv2.arrowedLine(
                tile,
                np.round(start).astype(int).tolist(),
                np.round(end).astype(int).tolist(),
                colour,
                width,
                cv2.LINE_AA,
                0,
                0.22,
            )
    return tile


def flow_tile(stretch: Stretch, flow: Flow | None, full_px: float, *, with_wheel: bool = True) -> Bytes:
    """Return the flow in colour, with the colour wheel and its scale."""
    if flow is None:
        return stretch.blank()
    colours = flow_rgb(flow.uv_px, flow.valid, full_px)
    tile = stretch.placed(np.asarray(stretch.resized(colours, flow.step_px), np.uint8))
    if not with_wheel:
        return tile
    wheel, disc = wheel_rgb(_WHEEL_PX)
    low, right = stretch.top + stretch.rows - 8, stretch.left + stretch.cols - 8
    tile[low - _WHEEL_PX : low, right - _WHEEL_PX : right][disc] = wheel[disc]
    middle = (right - _WHEEL_PX // 2, low - _WHEEL_PX // 2)
    cv2.circle(tile, middle, _WHEEL_PX // 2, (40, 40, 40), 1, cv2.LINE_AA)
    at = (right, low - _WHEEL_PX - 10)
    write(tile, f"rim {full_px:.1f} px", at, (20, 20, 20), align="right", ground=(255, 255, 255))
    return tile


def plane_tile(stretch: Stretch, camera: Bytes | None, plane: Plane | None, *, with_legend: bool = True) -> Bytes:
    """Return the dominant map over the picture: obstacle red, the rim dark, unknown cells striped violet.

    ``with_legend``: whether to name the stripes, where there are any.
    """
    if plane is None:
        return stretch.blank() if camera is None else stretch.placed(camera // 2)
    obstacle = stretch.resized((plane.obstacle != 0).astype(np.uint8), plane.step_px)
    unjudged = stretch.resized((plane.valid == 0).astype(np.uint8), plane.step_px)
    ground = np.full((*obstacle.shape, 3), 235, np.uint8) if camera is None else camera.copy()
    red = np.tile(np.array(style.rgb(style.REPULSIVE), np.uint8), (*obstacle.shape, 1))
    cv2.copyTo(cv2.addWeighted(ground, 0.4, red, 0.6, 0), obstacle, ground)
    cv2.copyTo(ground // 3, unjudged, ground)
    rims, _ = cv2.findContours(obstacle, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    cv2.drawContours(ground, rims, -1, (255, 120, 120), 1, cv2.LINE_AA)
    unknown = stretch.resized(plane.unknown().astype(np.uint8), plane.step_px)
    _stripe(ground, unknown)
    tile = stretch.placed(ground)
    if with_legend and unknown.any():
        at = (stretch.left + 8, stretch.top + stretch.rows - 10)
        write(tile, f"violet: unknown, {100 * plane.unknown_ratio():.0f} %", at, (20, 20, 20), ground=(255, 255, 255))
    return tile


def _stripe(picture: Bytes, there: Bytes) -> None:
    """Draw violet stripes where ``there`` is not 0."""
    violet = np.tile(np.array(style.rgb(style.UNKNOWN), np.uint8), (*there.shape, 1))
    rows, cols = there.shape
    diagonal = np.arange(rows)[:, None] + np.arange(cols)
    stripes = (there != 0) & (diagonal % _STRIPE_PX < _STRIPE_PX // 2)
    cv2.copyTo(cv2.addWeighted(picture, 0.2, violet, 0.8, 0), there & stripes, picture)


def potential_tile(stretch: Stretch, potential: Potential | None) -> Bytes:
    """Return the obstacle potential, minimum black and maximum white."""
    if potential is None:
        return stretch.blank()
    values = potential.potential
    low, span = float(values.min()), float(np.ptp(values))
    gray = ((values - low) * (255 / span if span > 1e-6 else 0.0)).astype(np.uint8)
    large = stretch.resized(gray, potential.step_px, cv2.INTER_LINEAR)
    return stretch.placed(np.asarray(cv2.cvtColor(large, cv2.COLOR_GRAY2RGB), np.uint8))
