"""The mounting of a camera from pictures of a board on the floor, and the level picture that stages are told of."""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import Mount
from graphnav.arrays import Doubles
from graphnav_io.boards import Corners
from graphnav_io.lens import Lens

MAX_ZOOM = 2.0
SEEN_PX = 0.05
"""A place so little beyond the outermost pixels counts as seen: it is hardly darker."""
_ZOOM_STEPS = 20
_BORDER_POINTS = 40


class Pose(NamedTuple):
    """Height above the floor, metres, tilt below the horizontal and roll, radians."""

    height_m: float
    tilt_rad: float
    roll_rad: float


def floor_pose(found: Corners, lens: Lens, quarter_turns: int) -> Pose:
    """Return the pose of a camera that sees a board on the floor.

    ``quarter_turns``: of the picture, counterclockwise, until the robot's front is up. The roll is about the robot's
    forward axis, above 0 with the camera's right side lower; the camera is taken to look along that axis.

    Raises
    ------
    ValueError
        No pose fits.
    """
    _, turns, shifts, _ = cv2.solvePnPGeneric(
        found.places_m, lens.rays(found.points_px), np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    if not turns:
        raise ValueError("no pose fits its corners")
    turn, shift = cv2.solvePnPRefineLM(found.places_m, lens.rays(found.points_px), np.eye(3), None, turns[0], shifts[0])
    up, place = cv2.Rodrigues(turn)[0][:, 2], shift.reshape(3)
    height_m = -float(up @ place)
    if height_m < 0:
        up, height_m = -up, -height_m
    x, y, z = quarter(quarter_turns) @ up
    return Pose(height_m, math.atan2(-z, -y), math.asin(float(np.clip(-x, -1.0, 1.0))))


def quarter(turns: int) -> Doubles:
    """Return the rotation from the camera's frame to that of its picture turned counterclockwise by quarters."""
    once = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return np.linalg.matrix_power(once, turns % 4)


def leveling(pose: Pose, tilt_deg: float, quarter_turns: int) -> Doubles:
    """Return the rotation (3, 3) from the camera to one of the same centre with this tilt and no roll."""
    c, s = math.cos(pose.roll_rad), math.sin(pose.roll_rad)
    rolled = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    R_CR = Mount(pose.height_m, math.degrees(pose.tilt_rad), 90.0, 0.0).R_CR
    level = Mount(pose.height_m, tilt_deg, 90.0, 0.0).R_CR @ rolled @ R_CR.T
    turned = quarter(quarter_turns)
    return np.asarray(turned.T @ level @ turned)


def level_camera(lens: Lens, rotation: Doubles, rows: int, cols: int) -> Doubles | None:
    """Return the camera matrix (3, 3) of the undistorted picture: square pixels, the optical axis in the middle.

    It has the focal length of the lens where every pixel of it is seen through the lens, else the smallest focal
    length above with which that is so; None where that is more than `MAX_ZOOM` times as long.
    """
    focal_px = math.sqrt(lens.camera[0, 0] * lens.camera[1, 1])
    if _is_seen(lens, rotation, focal_px, rows, cols):
        return _matrix(focal_px, rows, cols)
    low, high = 1.0, MAX_ZOOM
    if not _is_seen(lens, rotation, high * focal_px, rows, cols):
        return None
    for _ in range(_ZOOM_STEPS):
        middle = (low + high) / 2
        low, high = (low, middle) if _is_seen(lens, rotation, middle * focal_px, rows, cols) else (middle, high)
    return _matrix(high * focal_px, rows, cols)


def _matrix(focal_px: float, rows: int, cols: int) -> Doubles:
    return np.array([[focal_px, 0.0, (cols - 1) / 2], [0.0, focal_px, (rows - 1) / 2], [0.0, 0.0, 1.0]])


def _is_seen(lens: Lens, rotation: Doubles, focal_px: float, rows: int, cols: int) -> bool:
    """Return whether the border of the level picture lies in the picture of the lens."""
    x, y = (np.linspace(-0.5, 0.5, _BORDER_POINTS) * (n - 1) / focal_px for n in (cols, rows))
    ends = [np.stack([x, np.full_like(x, end)], axis=-1) for end in (y[0], y[-1])]
    ends += [np.stack([np.full_like(y, end), y], axis=-1) for end in (x[0], x[-1])]
    rays = np.concatenate(ends)
    seen = np.column_stack([rays, np.ones(len(rays))]) @ rotation  # to the camera's frame: the transpose
    if (seen[:, 2] <= 0.0).any():
        return False
    points = lens.project(seen, np.zeros(3), np.zeros(3))
    return bool((points >= -SEEN_PX).all() and (points <= np.array([cols - 1, rows - 1]) + SEEN_PX).all())
