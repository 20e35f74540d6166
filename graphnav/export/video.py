"""A run as a video: its panels, or the pictures of one channel."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt

from graphnav.catalog import Catalog
from graphnav.errors import DrawingError, UserError
from graphnav.export.placing import placed_file
from graphnav.export.reader import Reader
from graphnav.export.selection import Selection
from graphnav.export.walk import Walk
from graphnav.pictures import DRAWING_FAMILY, Pictures, VideoFrames, drawing

Bytes = npt.NDArray[np.uint8]
Frames = Iterator[tuple[int, Bytes]]

_SUFFIX = ".mp4"
_ROWS, _COLS = 480, 640
"""The box of one channel's pictures."""
_RATE_HZ = 10.0
"""Of a single picture, which has no rate."""


def write_video(
    reader: Reader, selection: Selection, catalog: Catalog, target: Path, channel: str | None, *, force: bool
) -> tuple[int, list[str]]:
    """Write a video of ``channel``, None for the panels; return the number of frames and what is missing.

    Raises
    ------
    UserError
        The log holds nothing to show, or nothing can be written there.
    GraphnavError
        The disk refuses.
    """
    catalog.load(DRAWING_FAMILY)
    undrawn: list[str] = []
    count = 0

    def told(frames: Frames) -> Frames:
        nonlocal count
        for utime, frame in frames:
            reader.on_time(reader.at_s(utime))
            count += 1
            yield utime, frame

    with placed_file(target, _SUFFIX, force=force) as file:
        if channel is None:
            video = _panels(reader, selection, catalog)
        else:
            video = _pictures(reader, channel, _drawn(reader, Pictures(catalog), undrawn))
        with drawing():
            video = video._replace(frames=told(video.frames))
            if catalog.hook.graphnav_write_video(frames=video, file=file) is None:
                raise UserError.of("no plugin that is installed writes videos", "install graphnav's own plugins")
    losses = reader.losses()
    if undrawn:
        losses.append(f"channel {channel!r}: {len(undrawn)} pictures are missing: {undrawn[-1]}")
    return count, losses


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
    rows, cols = (side + side % 2 for side in first[1].shape[:2])
    stamps = reader.recording.utimes(channel)
    period_us = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    fitted = ((utime, _within(picture, rows, cols)) for utime, picture in chain((first,), frames))
    return VideoFrames(1e6 / period_us if period_us > 0 else _RATE_HZ, len(stamps), fitted)


def _drawn(reader: Reader, pictures: Pictures, undrawn: list[str]) -> Frames:
    """Yield the pictures of the selected messages; why one cannot be drawn is added to ``undrawn``."""
    walk = Walk(reader)
    for sample in walk:
        message = reader.message(sample.channel, sample.fields)
        if message is None:
            continue
        try:
            picture = pictures.draw(message, walk.context(_ROWS, _COLS, with_legend=True))
        except DrawingError as error:
            undrawn.append(str(error))
            continue
        if picture is not None:
            yield sample.utime, picture


def _within(picture: Bytes, rows: int, cols: int) -> Bytes:
    """Return a picture in the upper left of a black frame, cut to it."""
    frame = np.zeros((rows, cols, 3), np.uint8)
    seen = picture[:rows, :cols]
    frame[: seen.shape[0], : seen.shape[1]] = seen
    return frame
