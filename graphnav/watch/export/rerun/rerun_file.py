"""Write Rerun recordings with a blueprint."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from uuid import uuid4

from graphnav.watch.export.entries.entries import Entry, Level, Line, Picture, Scalars
from graphnav.watch.export.entries.topics import PICTURE, parts_of
from graphnav.watch.export.extras import require
from graphnav.watch.export.files.piped_file import PipedFile
from graphnav.watch.export.rerun.rerun_columns import RerunColumns
from graphnav.watch.export.rerun.rerun_scene import RerunScene

APPLICATION = "graphnav"
TIMELINE = "time"
LOG_ENTITY = "log"

_LEVELS = {Level.INFO: "INFO", Level.WARNING: "WARN", Level.ERROR: "ERROR"}


class RerunFile:
    """Writes entries to entities named like the channels: ``control/twist/v_mps``, ``robot/image/picture``.

    The map, the path and the robot are below ``scene``, lines of text on ``log``. The timeline ``time`` counts from the
    beginning of the log; ``log_time`` and ``log_tick`` are Rerun's own, of the export.
    """

    def __init__(self, file: Path, begin_us: int, blueprint: Any) -> None:
        self._rr = require("rerun")
        self._begin_us = begin_us
        self._stream = self._rr.RecordingStream(APPLICATION, recording_id=uuid4(), send_properties=False)
        self._file = PipedFile(file)
        try:
            self._stream.save(self._file.path, default_blueprint=blueprint)
        finally:
            self._file.opened()
        self._columns: dict[str, RerunColumns] = {}
        self._scene = RerunScene(self._rr, self._stream)

    def add(self, entry: Entry) -> None:
        """Write an entry; raises OSError if writing fails."""
        self._file.check()
        at_s = (entry.utime - self._begin_us) / 1e6
        if isinstance(entry, Scalars):
            self._add_scalars(entry, at_s)
            return
        self._stream.set_time(TIMELINE, duration=at_s)
        if isinstance(entry, Picture):
            image = self._rr.EncodedImage(contents=entry.png(), media_type="image/png")
            self._stream.log([*parts_of(entry.channel), PICTURE], image)
        elif isinstance(entry, Line):
            text = f"{entry.source}: {entry.text}"
            self._stream.log(LOG_ENTITY, self._rr.TextLog(text, level=_LEVELS[entry.level]))
        else:
            self._scene.add(entry)

    def close(self) -> None:
        """Write buffered data."""
        for columns in self._columns.values():
            columns.send(self._rr, self._stream, TIMELINE)
        self._stream.disconnect()
        self._file.close()

    def _add_scalars(self, entry: Scalars, at_s: float) -> None:
        if entry.channel not in self._columns:
            self._columns[entry.channel] = RerunColumns(entry.channel, entry.lcm_class)
        columns = self._columns[entry.channel]
        if columns.add(entry, at_s):
            columns.send(self._rr, self._stream, TIMELINE)
