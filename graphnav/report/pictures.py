"""Pictures of a run, drawn from its log by the plugins that draw."""

from __future__ import annotations

from pathlib import Path

from graphnav.catalog import Catalog
from graphnav.errors import GraphnavError
from graphnav.pictures import DRAWING_FAMILY, drawing
from graphnav.record import Recording


def draw_pictures(catalog: Catalog, log: Path, folder: Path, *, video: bool) -> list[Path]:
    """Draw everything that the installed drawing plugins make of ``log`` into ``folder``; return the files.

    Raises
    ------
    DrawingError
        A plugin cannot draw what the log holds; what was drawn before is there.
    GraphnavError
        A picture cannot be written; the log has everything to draw it later.
    """
    catalog.load(DRAWING_FAMILY)
    try:
        with Recording(log) as recording, drawing():
            drawn = catalog.hook.graphnav_draw(recording=recording, folder=folder, video=video)
    except OSError as error:
        raise GraphnavError(
            f"cannot draw into {folder}: {error.strerror}\n  make room, then run: graphnav figure {folder}"
        ) from error
    return [path for paths in drawn for path in paths]
