"""A run as a video: its panels, or the pictures of one channel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from graphnav.arrays import Bytes
from graphnav.catalog import Catalog
from graphnav.errors import DrawingError, UserError
from graphnav.export.files.atomic_path import placed_file
from graphnav.export.log_pass import LogPass
from graphnav.export.reader import Reader
from graphnav.export.selection import Selection
from graphnav.messages import Image, Message
from graphnav.pictures import DRAWING_FAMILY, Pictures, VideoFrames, drawing

Frames = Iterator[tuple[int, Bytes]]

_SUFFIX = ".mp4"
_MIN_BOX, _MAX_BOX = (480, 640), (1080, 1920)
"""Rows and columns that one channel's pictures fit: those of its images, but within these."""
_RATE_HZ = 10.0
"""Of a single picture, which has no rate."""


@dataclass
class _Notes:
    """What is to be told of a channel's pictures: why some are missing, and their size if it was reduced."""

    undrawn: list[str] = field(default_factory=list)
    reduced: str = ""


def write_video(
    reader: Reader, selection: Selection, catalog: Catalog, target: Path, channel: str | None, *, force: bool
) -> tuple[str, list[str]]:
    """Write a video of ``channel``, None for the panels; return what it holds in words, and what is missing.

    Raises
    ------
    UserError
        The log holds nothing to show, or nothing can be written there.
    GraphnavError
        The disk refuses.
    """
    catalog.load(DRAWING_FAMILY)
    notes = _Notes()
    count = 0

    def told(frames: Frames) -> Frames:
        nonlocal count
        for utime, frame in frames:
            reader.on_time(reader.at_s(utime))
            count += 1
            yield utime, frame

    with placed_file(target, _SUFFIX, source=reader.recording.path, force=force) as file:
        if channel is None:
            video = _panels(reader, selection, catalog)
        else:
            video = _pictures(reader, channel, _drawn(reader, Pictures(catalog), notes))
        with drawing():
            video = video._replace(frames=told(video.frames))
            if catalog.hook.graphnav_write_video(frames=video, file=file) is None:
                raise UserError.of("no plugin that is installed writes videos", "install graphnav's own plugins")
    losses = reader.losses()
    if notes.undrawn:
        losses.append(f"channel {channel!r}: {len(notes.undrawn)} pictures are missing: {notes.undrawn[-1]}")
    return ("1 frame" if count == 1 else f"{count} frames") + notes.reduced, losses


def _panels(reader: Reader, selection: Selection, catalog: Catalog) -> VideoFrames:
    with drawing():
        video: VideoFrames | None = catalog.hook.graphnav_video_frames(
            recording=reader.recording, from_s=selection.from_s, until_s=selection.until_s
        )
    if video is None:
        raise UserError.of(
            f"{reader.recording.path} holds no images to make a video of",
            "record them: run: {record: all}; or name another channel with --channel",
        )
    return video


def _pictures(reader: Reader, channel: str, frames: Frames) -> VideoFrames:
    """Return the pictures of a channel, all of the size of the first."""
    first = next(frames, None)
    if first is None:
        raise UserError.of(
            f"channel '{channel}' holds no messages that have a picture",
            "name a channel of images, flow, planes or states, or leave --channel out for the panels",
        )
    rows, cols = _even_size(first[1])
    stamps = reader.recording.utimes(channel)
    period_us = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    fitted = ((utime, _within(picture, rows, cols)) for utime, picture in chain((first,), frames))
    return VideoFrames(1e6 / period_us if period_us > 0 else _RATE_HZ, len(stamps), fitted)


def _drawn(reader: Reader, pictures: Pictures, notes: _Notes) -> Frames:
    """Yield the pictures of the selected messages; ``notes`` gets what is to be told of them."""
    walk = LogPass(reader)
    for sample in walk:
        message = reader.message(sample.channel, sample.fields)
        if message is None:
            continue
        try:
            picture = pictures.draw(message, walk.context(*_box(message), with_legend=True))
        except DrawingError as error:
            notes.undrawn.append(str(error))
            continue
        if picture is not None:
            notes.reduced = notes.reduced or _reduced(message, picture)
            yield sample.utime, picture


def _box(message: Message) -> tuple[int, int]:
    """Return the rows and columns that the picture of a message has to fit."""
    if not isinstance(message, Image):
        return _MIN_BOX
    rows, cols = np.clip(message.pixels.shape[:2], _MIN_BOX, _MAX_BOX).tolist()
    return rows, cols


def _reduced(message: Message, picture: Bytes) -> str:
    """Return the words that tell the size of a picture that is smaller than its image, empty if it is not."""
    if not isinstance(message, Image) or picture.shape[0] >= message.pixels.shape[0]:
        return ""
    (rows, cols), (full_rows, full_cols) = _even_size(picture), message.pixels.shape[:2]
    return f" of {cols}x{rows}, reduced from {full_cols}x{full_rows}"


def _even_size(picture: Bytes) -> tuple[int, int]:
    """Return the rows and columns of the frame that holds a picture."""
    rows, cols = picture.shape[:2]
    return rows + rows % 2, cols + cols % 2


def _within(picture: Bytes, rows: int, cols: int) -> Bytes:
    """Return a picture in the upper left of a black frame, cut to it."""
    frame = np.zeros((rows, cols, 3), np.uint8)
    seen = picture[:rows, :cols]
    frame[: seen.shape[0], : seen.shape[1]] = seen
    return frame
