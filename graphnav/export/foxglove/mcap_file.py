"""A run as MCAP with Foxglove's own schemas: Foxglove shows it without a plugin."""

from __future__ import annotations

from pathlib import Path

from graphnav.export.entries.entries import Entry
from graphnav.export.extras import require
from graphnav.export.files.first_write_error import QuietFile
from graphnav.export.foxglove.foxglove_channels import FoxgloveChannels


class McapFile:
    """Writes entries as messages of Foxglove, stamped with the time of the log."""

    def __init__(self, file: Path) -> None:
        foxglove = require("foxglove")
        context = foxglove.Context()
        self._file = QuietFile(file)
        self._writer = foxglove.open_mcap(self._file, context=context)
        self._channels = FoxgloveChannels(context)

    def add(self, entry: Entry) -> None:
        """Write an entry; raises OSError where the disk refuses."""
        self._channels.add(entry)
        self._file.check()

    def close(self) -> None:
        """Write what is left, and the index by which viewers seek."""
        try:
            self._writer.close()
        finally:
            self._file.close()
