"""Write the entries of a run to a viewer's file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Protocol

from graphnav import UserError
from graphnav.watch.export.entries.entries import Entry
from graphnav.watch.export.entries.run_entries import RunEntries
from graphnav.watch.export.files.atomic_path import placed_file


class ViewerFile(Protocol):
    """A sink for the entries of a run."""

    def add(self, entry: Entry) -> None:
        """Write an entry."""

    def close(self) -> None:
        """Write buffered entries and close the file."""


def write_entries(
    entries: RunEntries, target: Path, suffix: str, open_file: Callable[[Path], ViewerFile], *, force: bool
) -> None:
    """Write the entries of a run into the file ``target``.

    Raises
    ------
    UserError
        The selection has no decodable message, or the target is not writable.
    GraphnavError
        Writing fails.
    """
    with placed_file(target, suffix, source=entries.reader.recording.path, force=force) as file:
        sink = open_file(file)
        try:
            for entry in entries:
                sink.add(entry)
        finally:
            sink.close()
        if not entries.reader.read.total():
            raise UserError.of(
                f"nothing to export from {entries.reader.recording.path}: no message can be decoded",
                "select other channels with --channel, or another span with --from and --until",
            )
