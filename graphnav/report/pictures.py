"""Pictures of a run, drawn from its log by the plugins that draw."""

from __future__ import annotations

from pathlib import Path

from graphnav.catalog import Catalog
from graphnav.record import Recording

DRAWING_FAMILY = "view"


def draw_pictures(catalog: Catalog, log: Path, folder: Path, *, video: bool) -> list[Path]:
    """Draw everything that the installed drawing plugins make of ``log`` into ``folder``; return the files."""
    catalog.load(DRAWING_FAMILY)
    drawn = catalog.hook.graphnav_draw(recording=Recording(log), folder=folder, video=video)
    return [path for paths in drawn for path in paths]
