"""Pictures of a recorded run, drawn from its log alone: map, panels, independent components, their norms, a video."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import hookimpl
from graphnav.arrays import Bytes

if TYPE_CHECKING:
    from graphnav import Message, PictureContext, Recording, VideoFrames


@hookimpl
def graphnav_draw(recording: Recording, folder: Path, video: bool, suffix: str) -> list[Path]:  # noqa: FBT001 - the hook's signature
    """Draw the content of the log into ``folder``; return the files, in a fixed order.

    A log without a map gives no ``map.png``, one without camera data no ``panels.png``, one without independent
    components no ``components.png`` and no ``norms.png``.
    """
    from graphnav_view.pictures import draw

    return draw(recording, folder, with_video=video, suffix=suffix)


@hookimpl
def graphnav_draw_end(recording: Recording, file: Path) -> Path | None:
    """Draw the map and the panels of the last frame; None if the log has neither a map nor camera data."""
    from graphnav_view.ending import draw_ending

    return draw_ending(recording, file)


@hookimpl
def graphnav_draw_paths(recordings: Mapping[str, Recording], colours: Mapping[str, str], file: Path) -> Path | None:
    """Draw one map with all paths; None if no log has a map and states."""
    from graphnav_view.maps.paths import draw_paths

    return draw_paths(recordings, colours, file)


@hookimpl
def graphnav_picture(message: Message, context: PictureContext) -> Bytes | None:
    """Draw images, flow, components, planes, potentials, forces and maps; None for other messages."""
    from graphnav_view.message_picture import picture_of

    return picture_of(message, context)


@hookimpl
def graphnav_draw_frames(
    recording: Recording, times_s: Sequence[float], folder: Path, suffix: str
) -> list[Path] | None:
    """Draw the panels of each frame; None if the log has no camera data."""
    from graphnav_view.panels.frames import draw_frames
    from graphnav_view.signals import Signals

    return draw_frames(Signals(recording), times_s, folder, suffix)


@hookimpl
def graphnav_draw_rows(recording: Recording, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw the paper's seven panels of each frame in a row; None if the log has no camera data."""
    from graphnav_view.panels.frame_rows import draw_rows
    from graphnav_view.signals import Signals

    return draw_rows(Signals(recording), times_s, file)


@hookimpl
def graphnav_draw_separation(recording: Recording, times_s: Sequence[float], file: Path) -> Path | None:
    """Draw the paper's I, u, v and D of each frame in a row; None if the log has no camera data."""
    from graphnav_view.panels.separation_rows import draw_separation_rows
    from graphnav_view.signals import Signals

    return draw_separation_rows(Signals(recording), times_s, file)


@hookimpl
def graphnav_draw_sheet(recording: Recording, every_s: float, from_s: float, until_s: float, file: Path) -> Path | None:
    """Draw the dominant plane over the picture and the control force, one frame per period."""
    from graphnav_view.panels.contact_sheet import draw_sheet
    from graphnav_view.signals import Signals

    return draw_sheet(Signals(recording), every_s, from_s, until_s, file)


@hookimpl
def graphnav_video_frames(recording: Recording, from_s: float, until_s: float) -> VideoFrames | None:
    """Return camera, flow, dominant plane and map side by side, a frame for each image."""
    from graphnav_view.signals import Signals
    from graphnav_view.video.video_frames import video_frames

    return video_frames(Signals(recording), from_s, until_s)


@hookimpl
def graphnav_write_video(frames: VideoFrames, file: Path) -> Path:
    """Write MPEG-4 that browsers play."""
    from graphnav_view.video.mp4 import write_frames

    return write_frames(frames, file)
