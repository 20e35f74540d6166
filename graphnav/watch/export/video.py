"""Export a run as a video of its panels, or of the pictures of one channel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from graphnav import Image, Message, UserError, VideoFrames
from graphnav.arrays import Bytes
from graphnav.core.catalog import Catalog
from graphnav.core.errors import DrawingError
from graphnav.core.pictures import DRAWING_FAMILY, Pictures, drawing
from graphnav.watch.export.files import placed_file
from graphnav.watch.export.log_pass import LogPass
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.selection import Selection

Frames = Iterator[tuple[int, Bytes]]

_SUFFIX = ".mp4"
_MIN_BOX, _MAX_BOX = (480, 640), (1080, 1920)
"""Limits of the rows and columns of a channel's pictures."""
_RATE_HZ = 10.0
"""The frame rate of a single picture."""


@dataclass
class _Notes:
    """Notes on a channel's pictures: drawing errors, and the size if it was reduced."""

    undrawn: list[str] = field(default_factory=list)
    reduced: str = ""


def write_video(
    reader: Reader, selection: Selection, catalog: Catalog, target: Path, channel: str | None, *, force: bool
) -> tuple[str, list[str]]:
    """Write a video of ``channel``, None for the panels; return a description of its content, and what is missing.

    Raises
    ------
    UserError
        The log holds nothing to show, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    catalog.load(DRAWING_FAMILY)
    notes = _Notes()
    count = 0

    def with_progress(frames: Frames) -> Frames:
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
            video = video._replace(frames=with_progress(video.frames))
            if catalog.hook.graphnav_write_video(frames=video, file=file) is None:
                raise UserError.of("no installed plugin writes videos", "install graphnav's own plugins")
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
            "record them: run: {record: all}; or select another channel with --channel",
        )
    return video


def _pictures(reader: Reader, channel: str, frames: Frames) -> VideoFrames:
    """Return the pictures of a channel, all with the size of the first one."""
    first = next(frames, None)
    if first is None:
        raise UserError.of(
            f"channel '{channel}' holds no messages with pictures",
            "select a channel of images, flow, planes or states, or omit --channel for the panels",
        )
    rows, cols = _even_size(first[1])
    stamps = reader.recording.utimes(channel)
    period_us = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    fitted = ((utime, _within(picture, rows, cols)) for utime, picture in chain((first,), frames))
    return VideoFrames(1e6 / period_us if period_us > 0 else _RATE_HZ, len(stamps), fitted)


def _drawn(reader: Reader, pictures: Pictures, notes: _Notes) -> Frames:
    """Yield the pictures of the selected messages; collects ``notes``."""
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
    """Return the maximum rows and columns of the picture of a message."""
    if not isinstance(message, Image):
        return _MIN_BOX
    rows, cols = np.clip(message.pixels.shape[:2], _MIN_BOX, _MAX_BOX).tolist()
    return rows, cols


def _reduced(message: Message, picture: Bytes) -> str:
    """Return a phrase with the size of a picture that is smaller than its image, else an empty string."""
    if not isinstance(message, Image) or picture.shape[0] >= message.pixels.shape[0]:
        return ""
    (rows, cols), (full_rows, full_cols) = _even_size(picture), message.pixels.shape[:2]
    return f" of {cols}x{rows}, reduced from {full_cols}x{full_rows}"


def _even_size(picture: Bytes) -> tuple[int, int]:
    """Return the even rows and columns of the frame for a picture."""
    rows, cols = picture.shape[:2]
    return rows + rows % 2, cols + cols % 2


def _within(picture: Bytes, rows: int, cols: int) -> Bytes:
    """Return a picture in the upper left of a black frame, cropped to it."""
    frame = np.zeros((rows, cols, 3), np.uint8)
    seen = picture[:rows, :cols]
    frame[: seen.shape[0], : seen.shape[1]] = seen
    return frame
