"""The hooks by which plugins enter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pluggy

from graphnav.adapter import Adapter
from graphnav.arrays import Bytes
from graphnav.stage import Stage

if TYPE_CHECKING:
    from graphnav.messages import Message
    from graphnav.pictures import PictureContext, VideoFrames
    from graphnav.record import Recording
    from graphnav.spec import FileFormat

PROJECT = "graphnav"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def graphnav_stages() -> list[type[Stage]]:  # type: ignore[empty-body]
    """Return the stage classes of a plugin; the entry point's name is their family."""


@hookspec
def graphnav_adapters() -> list[Adapter]:  # type: ignore[empty-body]
    """Return the adapters of a plugin between LCM types of other packages and messages of ours."""


@hookspec
def graphnav_file_formats() -> list[FileFormat[Any]]:  # type: ignore[empty-body]
    """Return the formats of the files that a plugin reads, for ``graphnav schema --of NAME``."""


@hookspec
def graphnav_draw(recording: Recording, folder: Path, video: bool, suffix: str) -> list[Path]:  # type: ignore[empty-body] # noqa: FBT001
    """Draw pictures (and a video, if asked) of a recorded run into ``folder``; return what was written.

    ``suffix``: of the pictures' names, which says their format: ``.png``, ``.svg`` or ``.pdf``. A plugin that writes
    PNG only leaves this argument out.

    Everything is drawn from the log, so that a log from another machine draws the same.
    """


@hookspec(firstresult=True)
def graphnav_draw_end(recording: Recording, file: Path) -> Path | None:
    """Draw how a recorded run ended into the picture ``file``: the map, and the panels of the last frame.

    Return ``file``, or None, without writing, where the log is not enough.
    """


@hookspec(firstresult=True)
def graphnav_draw_paths(recordings: Mapping[str, Recording], colours: Mapping[str, str], file: Path) -> Path | None:
    """Draw the paths that several runs took through one world over its map into the picture ``file``.

    ``recordings``, ``colours`` (``#rrggbb``): by the name of whatever drove; the last is drawn on top. Return ``file``,
    or None, without writing, where the logs are not enough.
    """


@hookspec(firstresult=True)
def graphnav_picture(message: Message, context: PictureContext) -> Bytes | None:
    """Draw one message as a picture; the first plugin that can, draws it.

    Return uint8 (rows, cols, 3), red-green-blue, rows down; None for a message type that has no picture. The picture
    keeps the shape of what it shows and fills the box of ``context.rows`` x ``context.cols`` pixels in one direction:
    grids are enlarged or reduced to it, one message gives one picture and nothing is kept for the next.

    ``context.find(Image)`` returns the message of another type that belongs to this one (the image below a plane, the
    map around a state) or None, ``context.path_m()`` where the robot was, float64 (n, 2). Both may be slow: call them
    for what is drawn only. Without ``context.with_legend`` the picture has no letters and no scales: it may be
    60 pixels high.

    The message may come from any program: its numbers need not be finite, its shapes need not agree with those of
    other messages. What is raised becomes a DrawingError, and the viewer says it in place of the picture.
    """


@hookspec(firstresult=True)
def graphnav_draw_frames(
    recording: Recording, times_s: Sequence[float], folder: Path, suffix: str
) -> list[Path] | None:
    """Draw the panels of single frames of a recorded run into ``folder``, one picture each; return the files.

    ``times_s``: seconds since the log begins; of each, the frame nearest to it is drawn. ``suffix``: ``.png``, ``.svg``
    or ``.pdf``. Return None where the log holds nothing that a camera saw; raise UserError for a time outside of it.
    """


@hookspec(firstresult=True)
def graphnav_draw_sheet(recording: Recording, every_s: float, from_s: float, until_s: float, file: Path) -> Path | None:
    """Draw a contact sheet of a recorded run: a frame every so many seconds, small, side by side.

    ``from_s``, ``until_s``: seconds since the log begins; they may lie outside of it. The suffix of ``file`` says its
    format: ``.png``, ``.svg`` or ``.pdf``. Return ``file``, or None, without writing, where the log holds nothing that
    a camera saw; raise UserError for a span without frames, or more frames than a sheet holds.
    """


@hookspec(firstresult=True)
def graphnav_video_frames(recording: Recording, from_s: float, until_s: float) -> VideoFrames | None:
    """Return the frames of the video of a recorded run, its panels, between two times (seconds since the log begins).

    Return None where the log holds no images in that span.
    """


@hookspec(firstresult=True)
def graphnav_write_video(frames: VideoFrames, file: Path) -> Path | None:
    """Write frames as a video; the suffix of ``file`` says its format. Return ``file``.

    Raise UserError where this machine cannot write it, OSError where the file does not hold every frame.
    """
