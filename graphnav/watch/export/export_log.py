"""Export a log to another format."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from graphnav import Recording
from graphnav.core.catalog import Catalog
from graphnav.watch.export.formats import FORMATS, Job
from graphnav.watch.export.reader import Reader
from graphnav.watch.export.selection import Selection


class Exported(NamedTuple):
    """The result of an export: its size, a description of its content, and a sentence per missing part."""

    n_bytes: int
    contents: str
    losses: list[str]


def export_log(
    recording: Recording,
    kind: str,
    target: Path,
    selection: Selection | None = None,
    *,
    force: bool = False,
    storage: str = "mcap",
    catalog: Catalog | None = None,
    on_time: Callable[[float], None] = lambda _: None,
) -> Exported:
    """Write the selected part of a log to ``target``, in one of the `FORMATS`.

    ``target`` is created when it is complete; tables of several channels and bags are folders, everything else a file.
    From a damaged log the intact messages are exported. ``storage``: of a ROS 2 bag, ``mcap`` or ``sqlite3``.
    ``on_time`` is called with the progress, seconds of the log.

    Raises
    ------
    UserError
        The selection or the target is not usable, or a package is missing.
    GraphnavError
        Writing fails, or a plugin cannot draw.
    """
    selection, catalog = selection or Selection(), catalog or Catalog()
    reader = Reader(recording, selection, catalog, on_time)
    selection.check_span(recording)
    written = FORMATS[kind](Job(reader, selection, catalog, target, force, storage))
    n_bytes = sum(file.stat().st_size for file in written.files)
    return Exported(n_bytes, written.contents, written.losses)
