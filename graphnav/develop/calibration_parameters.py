"""The parameters that ``graphnav calibrate`` and `graphnav.calibrate` share."""

from __future__ import annotations

import argparse
import math
import re
from pathlib import Path

from graphnav.core.parameters import Parameter, flag

MAX_COUNT = 100
MAX_M = 10.0


def board_size(text: str) -> tuple[int, int]:
    """Parse the size of a board, such as 9x6."""
    match = re.fullmatch(r"(\d{1,3})x(\d{1,3})", text)
    size = (int(match[1]), int(match[2])) if match else (0, 0)
    if all(3 <= count <= MAX_COUNT for count in size):
        return size
    raise argparse.ArgumentTypeError(f"'{text}' is not a board of 3x3 to {MAX_COUNT}x{MAX_COUNT}: write 9x6")


def metres(text: str) -> float:
    """Parse a length above 0."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if 0 < value <= MAX_M:
        return value
    raise argparse.ArgumentTypeError(f"'{text}' is not a length in metres above 0, at most {MAX_M:g}: write 0.025")


def columns(text: str) -> int:
    """Parse the columns of a picture."""
    if text.isascii() and text.isdecimal() and 16 <= int(text[:6]) <= 4096:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is not a number of columns from 16 to 4096")


PICTURES = Parameter(
    "pictures",
    metavar="PICTURES",
    nargs="*",
    type=Path,
    help="pictures of the board, a folder or a pattern of them, a video, a log or a run folder with images",
    doc="Pictures of the board, folders or patterns of them, videos, logs and run folders with images.",
    example='["pictures"]',
)
BOARD = Parameter(
    "board",
    "--board",
    type=board_size,
    metavar="COLSxROWS",
    help="inner corners of the checkerboard (9x6), as OpenCV and ROS count; with --charuco its squares",
    doc='Inner corners of the checkerboard, as OpenCV and ROS count: ``"9x6"``; of a ChArUco board its squares.',
    example='"9x6"',
)
SQUARE_M = Parameter(
    "square_m",
    "--square",
    type=metres,
    metavar="M",
    help="side of a square in metres, as measured on the printed board",
    doc="The side of a square in metres, as measured on the printed board.",
    example="0.025",
)
CHARUCO = flag("charuco", "--charuco", "the board is a ChArUco board, of which a part suffices")
MARKER_M = Parameter(
    "marker_m",
    "--marker",
    type=metres,
    metavar="M",
    help="with --charuco: side of a marker in metres (default: 0.75 of a square)",
    doc="The side of a ChArUco board's markers in metres; None: the board is a checkerboard.",
    example="0.018",
)
DICTIONARY = Parameter(
    "dictionary",
    "--dict",
    metavar="NAME",
    default="4X4_50",
    help="with --charuco: dictionary of its markers, as OpenCV names it (default: %(default)s)",
    doc="The dictionary of a ChArUco board's markers, as OpenCV names it without ``DICT_``.",
    example='"4X4_50"',
)
FLOOR = Parameter(
    "floor",
    "--floor",
    metavar="PICTURES",
    nargs="+",
    type=Path,
    default=[],
    help="pictures of the board on the floor, the camera on the robot: they give height, tilt and roll",
    doc="Pictures of the board on the floor, with the camera on the robot: they give its height, tilt and roll.",
    example='["floor"]',
)
ROTATE_DEG = Parameter(
    "rotate_deg",
    "--rotate",
    choices=("0", "90", "180", "270"),
    default="0",
    help="how far its pictures are turned counterclockwise, in degrees, until the robot's front is up",
    doc="How far the pictures are turned counterclockwise until the robot's front is up: 0, 90, 180 or 270.",
    example="180",
)
FISHEYE = flag(
    "fisheye",
    "--fisheye",
    "fit OpenCV's fisheye model: for lenses that see more than about 110 degrees",
    doc="Fit OpenCV's fisheye model, for lenses that see more than about 110 degrees.",
)
COLUMNS = Parameter(
    "columns",
    "--columns",
    type=columns,
    default=160,
    metavar="N",
    help="columns of the pictures that the graph works on; rows keep the shape (default: %(default)s)",
    doc="Columns of the pictures that the graph works on; their rows keep the shape.",
    example="160",
)
OUTPUT = Parameter(
    "output",
    "-o",
    type=Path,
    metavar="FILE",
    default=Path("my_camera.yaml"),
    help="the camera's YAML, which graphs extend; the calibration and a contact sheet are written beside it "
    "(default: %(default)s)",
    doc="The camera's YAML, which graphs extend; the calibration and a contact sheet are written beside it.",
    example='"my_camera.yaml"',
)
FORCE = flag("force", "--force", "replace existing files", doc="Replace existing files.")
