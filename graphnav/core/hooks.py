"""The hook specifications for plugins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pluggy

from graphnav.arrays import Bytes
from graphnav.core.adapter import Adapter
from graphnav.core.stage import Stage

if TYPE_CHECKING:
    from graphnav.core.camera_calibration import CalibrationBoard, CalibrationTask, CameraCalibration
    from graphnav.core.drawing import PictureContext, VideoFrames
    from graphnav.core.messages import Message
    from graphnav.core.record import Recording
    from graphnav.core.spec import FileFormat

PROJECT = "graphnav"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def graphnav_stages() -> list[type[Stage]]:  # type: ignore[empty-body]
    """Return the stage classes of a plugin; the entry point's name is their family."""


@hookspec
def graphnav_adapters() -> list[Adapter]:  # type: ignore[empty-body]
    """Return the adapters of a plugin between LCM types of other packages and graphnav's messages."""


@hookspec
def graphnav_file_formats() -> list[FileFormat[Any]]:  # type: ignore[empty-body]
    """Return the formats of the files that a plugin reads, for ``graphnav schema --of NAME``."""


@hookspec
def graphnav_draw(recording: Recording, folder: Path, video: bool, suffix: str) -> list[Path]:  # type: ignore[empty-body] # noqa: FBT001
    """Draw pictures (and a video, if requested) of a recorded run into ``folder``; return the written files.

    ``suffix``: the suffix of the pictures, which determines their format: ``.png``, ``.svg`` or ``.pdf``. A plugin that
    writes only PNG omits this argument.

    Pictures are drawn from the log alone, so that a log from another machine gives the same pictures.
    """


@hookspec(firstresult=True)
def graphnav_draw_end(recording: Recording, file: Path) -> Path | None:
    """Draw the end of a recorded run into the picture ``file``: the map, and the panels of the last frame.

    Return ``file``, or None, without writing, if the log is not sufficient.
    """


@hookspec(firstresult=True)
def graphnav_draw_paths(recordings: Mapping[str, Recording], colours: Mapping[str, str], file: Path) -> Path | None:
    """Draw the paths of several runs through one world over its map into the picture ``file``.

    ``recordings``, ``colours`` (``#rrggbb``): by the name of the variant; the last is drawn on top. Return ``file``, or
    None, without writing, if the logs are not sufficient.
    """


@hookspec(firstresult=True)
def graphnav_picture(message: Message, context: PictureContext) -> Bytes | None:
    """Draw one message as a picture; the first result that is not None is used.

    Return uint8 (rows, cols, 3), red-green-blue, rows down; None for a message type that has no picture. The picture
    keeps the aspect ratio of its content and fills the box of ``context.rows`` x ``context.cols`` pixels in one
    direction. The hook is stateless: one message gives one picture.

    ``context.find(Image)`` returns the message of another type that belongs to this one (the image below a plane, the
    map around a state) or None, ``context.path_m()`` the robot's path, float64 (n, 2). Both may be slow: call them
    only for what is drawn. Without ``context.with_legend`` the picture has no text and no scales: it may be as small
    as 60 pixels high.

    The message may come from any program: its values may be infinite or NaN, its shapes may disagree with those of
    other messages. An exception becomes a DrawingError, which the viewer shows in place of the picture.
    """


@hookspec(firstresult=True)
def graphnav_draw_frames(
    recording: Recording, times_s: Sequence[float], folder: Path, suffix: str
) -> list[Path] | None:
    """Draw the panels of single frames of a recorded run into ``folder``, one picture each; return the files.

    ``times_s``: seconds since the log begins; for each the nearest frame is drawn. ``suffix``: ``.png``, ``.svg`` or
    ``.pdf``. Return None if the log holds no images; raise UserError for a time outside of it.
    """


@hookspec(firstresult=True)
def graphnav_draw_rows(recording: Recording, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw single frames of a recorded run into one picture ``file``: a row for each frame, its panels side by side.

    ``times_s``: seconds since the log begins; for each the nearest frame is drawn, in the order of time. Return
    ``file``, or None, without writing, if the log holds no images; raise UserError for a time outside of it.
    """


@hookspec(firstresult=True)
def graphnav_draw_separation(recording: Recording, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw how single frames of a recorded run were separated into one picture ``file``, a row for each frame.

    A row has the image, its flow, the component that the obstacles were found in, and the dominant plane. ``times_s``
    and the result: as for `graphnav_draw_rows`; raise UserError also for a log without independent components.
    """


@hookspec(firstresult=True)
def graphnav_draw_sheet(recording: Recording, every_s: float, from_s: float, until_s: float, file: Path) -> Path | None:
    """Draw a contact sheet of a recorded run: small frames at regular intervals, side by side.

    ``from_s``, ``until_s``: seconds since the log begins; they may lie outside of it. The suffix of ``file``
    determines its format: ``.png``, ``.svg`` or ``.pdf``. Return ``file``, or None, without writing, if the log holds
    no images; raise UserError for a span without frames, or more frames than fit on a sheet.
    """


@hookspec(firstresult=True)
def graphnav_video_frames(recording: Recording, from_s: float, until_s: float) -> VideoFrames | None:
    """Return the frames of a panel video of a recorded run between two times (seconds since the log begins).

    Return None if the log holds no images in that span.
    """


@hookspec(firstresult=True)
def graphnav_write_video(frames: VideoFrames, file: Path) -> Path | None:
    """Write frames as a video; the suffix of ``file`` determines its format. Return ``file``.

    Raise UserError if this machine cannot write the format, OSError if writing fails.
    """


@hookspec(firstresult=True)
def graphnav_calibrate(task: CalibrationTask) -> CameraCalibration | None:
    """Calibrate a camera from pictures of a board; the first result that is not None is used.

    Every picture is judged, and the contact sheet ``task.sheet`` written, also where there is no calibration: then the
    result holds the problem. Raise UserError for what cannot be read or written.
    """


@hookspec(firstresult=True)
def graphnav_print_board(board: CalibrationBoard, file: Path) -> tuple[float, float] | None:
    """Write a calibration board to be printed without scaling; return width and height of the page, metres.

    The suffix of ``file`` determines its format: ``.png`` or ``.pdf``. Raise UserError for a board that cannot be
    made, or a file that cannot be written.
    """
