"""Write MCAP files with Foxglove's schemas, which Foxglove shows without a plugin."""

from __future__ import annotations

from pathlib import Path

from graphnav.watch.export.entries.entries import Entry
from graphnav.watch.export.extras import require
from graphnav.watch.export.files.first_write_error import QuietFile
from graphnav.watch.export.foxglove.foxglove_channels import FoxgloveChannels


class McapFile:
    """Writes entries as Foxglove messages with log time."""

    def __init__(self, file: Path) -> None:
        foxglove = require("foxglove")
        context = foxglove.Context()
        self._file = QuietFile(file)
        self._writer = foxglove.open_mcap(self._file, context=context)
        self._channels = FoxgloveChannels(context)

    def add(self, entry: Entry) -> None:
        """Write an entry; raises OSError if writing fails."""
        self._channels.add(entry)
        self._file.check()

    def close(self) -> None:
        """Write buffered data and the index for seeking."""
        try:
            self._writer.close()
        finally:
            self._file.close()
