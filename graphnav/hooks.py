"""The hooks by which plugins enter."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pluggy

from graphnav.stage import Stage

if TYPE_CHECKING:
    from graphnav.record import Recording

PROJECT = "graphnav"

hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


@hookspec
def graphnav_stages() -> list[type[Stage]]:  # type: ignore[empty-body]
    """Return the stage classes of a plugin; the entry point's name is their family."""


@hookspec
def graphnav_draw(recording: Recording, folder: Path, video: bool) -> list[Path]:  # type: ignore[empty-body] # noqa: FBT001
    """Draw pictures (and a video, if asked) of a recorded run into ``folder``; return what was written.

    Everything is drawn from the log, so that a log from another machine draws the same.
    """
