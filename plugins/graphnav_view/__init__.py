"""Pictures of a recorded run, drawn from its log alone: ``map.png``, ``panels.png``, ``video.mp4``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from graphnav import hookimpl

if TYPE_CHECKING:
    from graphnav import Message, PictureContext, Recording


@hookimpl
def graphnav_draw(recording: Recording, folder: Path, video: bool) -> list[Path]:  # noqa: FBT001 - the hook's signature
    """Draw what the log holds into ``folder``; return what was written, in a fixed order.

    A log without a map gives no ``map.png``, one without anything that a camera saw no ``panels.png``.
    """
    from graphnav_view.pictures import draw  # noqa: PLC0415 - Matplotlib and OpenCV only when something is drawn

    return draw(recording, folder, with_video=video)


@hookimpl
def graphnav_draw_end(recording: Recording, file: Path) -> Path | None:
    """Draw the map and the panels of the last frame; None where the log has neither a map nor what a camera saw."""
    from graphnav_view.ending import draw_ending  # noqa: PLC0415 - Matplotlib and OpenCV only when something is drawn

    return draw_ending(recording, file)


@hookimpl
def graphnav_draw_paths(recordings: Mapping[str, Recording], colours: Mapping[str, str], file: Path) -> Path | None:
    """Draw one map with all paths; None where no log has a map and states."""
    from graphnav_view.paths import draw_paths  # noqa: PLC0415 - Matplotlib only when something is drawn

    return draw_paths(recordings, colours, file)


@hookimpl
def graphnav_picture(message: Message, context: PictureContext) -> npt.NDArray[np.uint8] | None:
    """Draw an image, a flow, a plane, a potential, a force, or the robot on its map; None for other messages."""
    from graphnav_view.message_picture import picture_of  # noqa: PLC0415 - OpenCV only when something is drawn

    return picture_of(message, context)
