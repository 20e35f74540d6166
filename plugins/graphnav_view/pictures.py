"""All pictures of one recording, in a fixed order."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graphnav_view.overview import draw_overview
from graphnav_view.panels import draw_panels
from graphnav_view.signals import Signals
from graphnav_view.video import write_video

if TYPE_CHECKING:
    from graphnav import Recording


def draw(recording: Recording, folder: Path, *, with_video: bool) -> list[Path]:
    """Draw the map, the panels and, if asked, the video; return the files that the log was enough for."""
    signals = Signals(recording)
    written = [draw_overview(signals, folder / "map.png"), draw_panels(signals, folder / "panels.png")]
    if with_video:
        written.append(write_video(signals, folder / "video.mp4"))
    return [path for path in written if path is not None]
