"""The hooks by which plugins enter."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pluggy

from graphnav.adapter import Adapter
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
def graphnav_adapters() -> list[Adapter]:  # type: ignore[empty-body]
    """Return the adapters of a plugin between LCM types of other packages and messages of ours."""


@hookspec
def graphnav_draw(recording: Recording, folder: Path, video: bool) -> list[Path]:  # type: ignore[empty-body] # noqa: FBT001
    """Draw pictures (and a video, if asked) of a recorded run into ``folder``; return what was written.

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
