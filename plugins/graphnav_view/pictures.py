"""Draw all pictures of a recording, in a fixed order."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import UserError
from graphnav_view.maps.overview import draw_overview
from graphnav_view.panels.key_panels import draw_panels
from graphnav_view.panels.norms_page import draw_norms
from graphnav_view.panels.separation_page import draw_components
from graphnav_view.signals import Signals
from graphnav_view.video.mp4 import write_frames
from graphnav_view.video.video_frames import video_frames

if TYPE_CHECKING:
    from graphnav import Recording


def draw(recording: Recording, folder: Path, *, with_video: bool, suffix: str = ".png") -> list[Path]:
    """Draw map, panels, components, norms and optionally the video, as far as the log has the data; return the files.

    Raises UserError for a video of a log without images.
    """
    signals = Signals(recording)
    written = [
        draw_overview(signals, folder / f"map{suffix}"),
        draw_panels(signals, folder / f"panels{suffix}"),
        draw_components(signals, folder / f"components{suffix}"),
        draw_norms(signals, folder / f"norms{suffix}"),
    ]
    if with_video:
        video = video_frames(signals)
        if video is None:
            raise UserError.of("the log does not contain images for a video", "record them: run: {record: all}")
        written.append(write_frames(video, folder / "video.mp4"))
    return [path for path in written if path is not None]
