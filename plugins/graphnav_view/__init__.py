"""Pictures of a recorded run, drawn from its log alone: ``map.png``, ``panels.png``, ``video.mp4``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from graphnav import hookimpl

if TYPE_CHECKING:
    from graphnav import Recording


@hookimpl
def graphnav_draw(recording: Recording, folder: Path, video: bool) -> list[Path]:  # noqa: FBT001 - the hook's signature
    """Draw what the log holds into ``folder``; return what was written, in a fixed order.

    A log without a map gives no ``map.png``, one without anything that a camera saw no ``panels.png``.
    """
    from graphnav_view.pictures import draw  # noqa: PLC0415 - Matplotlib and OpenCV only when something is drawn

    return draw(recording, folder, with_video=video)
