"""Read pictures of a calibration board: from files, folders, videos and logs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from graphnav import Image, ParamError, Place, UserError, open_log
from graphnav.arrays import Bytes
from graphnav_io.boards import Fault
from graphnav_io.capture import open_capture
from graphnav_io.pictures import SUFFIXES, find_pictures, is_pictures, read_picture

EVERY_S = 0.5
"""Time between two pictures of a video or a log: a board that is moved by hand has then another pose."""
MAX_PICTURES = 400
"""All of one command: more take minutes, and tell no more."""
_EMPTY = np.zeros((0, 0), np.uint8)
LOG_SUFFIX = re.compile(r"\.lcmlog(\.\d+)?$")


class Shot(NamedTuple):
    """A picture, gray, and its name in tables; ``fault``: why it cannot be read; the picture is then empty."""

    name: str
    gray: Bytes
    fault: Fault | None = None


def read_shots(paths: Sequence[Path], option: str) -> Iterator[Shot]:
    """Yield the pictures of files, folders, patterns, videos, logs and run folders; ``option``: names them in errors.

    Raises
    ------
    UserError
        A path names no pictures, or there are more than `MAX_PICTURES`.
    """
    count = 0
    for path in paths:
        for shot in _shots(path, option):
            count += 1
            if count > MAX_PICTURES:
                what = f"there are more than {MAX_PICTURES} pictures"
                raise UserError.of(what, "give the 20 to 50 that show the board best", Place(option))
            yield shot


def _shots(path: Path, option: str) -> Iterator[Shot]:
    try:
        if _is_log(path):
            yield from _of_log(path, option)
        elif is_pictures(path) or path.suffix.lower() in SUFFIXES:
            for file in find_pictures(path):
                yield _of_file(file)
        else:
            yield from _of_video(path)
    except ParamError as error:
        raise UserError.of(error.what, error.hint, Place(option)) from error


def _is_log(path: Path) -> bool:
    if path.is_dir():
        return any(LOG_SUFFIX.search(file.name) for file in path.iterdir())
    return LOG_SUFFIX.search(path.name) is not None


def _of_file(file: Path) -> Shot:
    try:
        return Shot(file.name, _gray(read_picture(file)))
    except ValueError as error:
        return Shot(file.name, _EMPTY, Fault(str(error)))


def _of_video(path: Path) -> Iterator[Shot]:
    frames = open_capture(path)
    try:
        if frames.is_live:
            what = f"'{path}' is a camera or a stream"
            raise ParamError("path", what, "record it first: graphnav record, or save pictures")
        step = max(1, round(EVERY_S * (frames.rate_hz or 1 / EVERY_S)))
        number = 0
        while (pixels := frames.read()) is not None:
            if number % step == 0:
                yield Shot(f"{path.name}#{number}", _gray(pixels))
            number += 1
    except ValueError as error:
        yield Shot(path.name, _EMPTY, Fault(str(error)))
    finally:
        frames.close()


def _of_log(path: Path, option: str) -> Iterator[Shot]:
    with open_log(path) as log:
        names = [name for name, channel in log.channels.items() if channel.message is Image]
        if len(names) != 1:
            what = f"'{path}' has {len(names)} channels with images" + (f": {', '.join(names)}" if names else "")
            hint = "write one as pictures: graphnav export LOG --to images --channel NAME -o pictures"
            raise UserError.of(what, hint if names else "record the camera: graphnav record CAMERA", Place(option))
        due_s = 0.0
        for sample in log.messages(names[0]):
            if sample.time_s >= due_s:
                due_s = sample.time_s + EVERY_S
                yield Shot(f"{path.name}@{sample.time_s:.1f}s", _gray(sample.message.pixels))


def _gray(pixels: Bytes) -> Bytes:
    gray: Bytes = pixels if pixels.ndim == 2 else cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY)
    return gray
