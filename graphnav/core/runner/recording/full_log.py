"""Every message of a lockstep run, for as long as its pictures are drawn."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.core.errors import LogError, shown_path
from graphnav.core.machine.system import open_file
from graphnav.core.record import LogWriter, Recording

_NAME = ".full.lcmlog"
_MIN_FREE_BYTES = 512 << 20
"""Free space of the disk below which the full log gives way to the log that stays."""
LOOK_BYTES = 16 << 20
"""So many bytes are written between two looks at the disk."""


def is_nearly_full(folder: Path) -> bool:
    """Return whether a disk has too little free space for what is kept only while a run lasts."""
    try:
        return shutil.disk_usage(folder).free < _MIN_FREE_BYTES
    except OSError:
        return False


class FullLog:
    """A log of everything that a run published, beside the log of its folder, which leaves out what can be made again.

    Its file has no name from the start, so that it takes no space once this process has ended, however it ends; on
    Windows, which removes no open file, it has one until it is closed. If the
    disk gets full, or refuses it, the full log is given up: then pictures show what the log of the folder holds.
    """

    def __init__(self) -> None:
        self._writer: LogWriter | None = None
        self._fd = -1
        self._folder = Path()
        self._path: Path | None = None
        self._looked_bytes = 0
        self._is_given_up = False

    def open(self, folder: Path) -> None:
        """Begin the log, on the disk of a run folder."""
        self._folder = folder
        path = self._path = folder / _NAME
        try:
            self._writer = LogWriter(path)
            self._fd = open_file(path, os.O_RDONLY)
        except OSError:
            self._give_up()
        finally:
            with suppress(OSError):
                path.unlink()
        self._look_at_disk()

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event, unless the log was given up; never raises."""
        if self._writer is None:
            return
        try:
            self._writer.write(channel, utime, data)
        except LogError:
            self._give_up()
            return
        if self._writer.n_bytes - self._looked_bytes >= LOOK_BYTES:
            self._looked_bytes = self._writer.n_bytes
            self._look_at_disk()

    def recording(self, log: Path, tell: Callable[[str], None]) -> Recording:
        """Return the recording of a run: ``log`` with everything that it leaves out, unless this log was given up.

        ``tell`` then gets a notice. Raises LogError if it cannot be read.
        """
        if self._writer is not None:
            try:
                self._writer.flush()
            except LogError:
                self._give_up()
        if self._is_given_up:
            folder = shown_path(log.parent)
            tell(
                f"the pictures show only what the log of {folder} holds: its disk takes no full log while they are "
                f"drawn, for which it has to have {_MIN_FREE_BYTES >> 20} MiB free\n"
                f"  free space, then run: graphnav figure {folder}"
            )
        return Recording(log, self._fd if self._fd >= 0 else None)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._give_up()

    def _look_at_disk(self) -> None:
        if is_nearly_full(self._folder):
            self._give_up()

    def _give_up(self) -> None:
        """Close the file, which frees its space."""
        if self._writer is not None:
            with suppress(LogError):
                self._writer.close()
        if self._fd >= 0:
            os.close(self._fd)
        if self._path is not None:
            with suppress(OSError):
                self._path.unlink(missing_ok=True)
        self._writer, self._fd = None, -1
        self._is_given_up = True
