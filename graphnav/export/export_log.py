"""Export a log to a format of other programs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from graphnav.catalog import Catalog
from graphnav.export.formats import FORMATS, Job
from graphnav.export.reader import Reader
from graphnav.export.selection import Selection
from graphnav.record import Recording


class Exported(NamedTuple):
    """What an export wrote: its size, what it holds in words, and what of the selection is missing, a sentence each."""

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
    catalog: Catalog | None = None,
    on_time: Callable[[float], None] = lambda _: None,
) -> Exported:
    """Write what is selected of a log into ``target``, in one of the `FORMATS`.

    ``target`` appears when it is complete; tables of several channels are a folder, everything else a file. A log that
    is damaged gives what is complete. ``on_time`` is called with the seconds of the log that are done.

    Raises
    ------
    UserError
        The selection, the target or a missing package.
    GraphnavError
        The disk refuses, or a plugin cannot draw.
    """
    selection, catalog = selection or Selection(), catalog or Catalog()
    reader = Reader(recording, selection, catalog, on_time)
    selection.check_span(recording)
    written = FORMATS[kind](Job(reader, selection, catalog, target, force))
    n_bytes = sum(file.stat().st_size for file in written.files)
    return Exported(n_bytes, written.contents, written.losses)
