"""Mark in the run folder which stage is called, so that a run whose process died can tell."""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from graphnav.core.machine.system import is_locked, lock_file, open_file, write_at

PROGRESS = "progress"
"""A file of a run folder that exists while the run does, locked by its process, and after it if the process died."""

_METHODS = ("", "reset", "step", "due_us", "patience_s", "summary", "close")
_RECORD = struct.Struct("<iiq")
"""The last call: the index of the stage, that of the method, and the stamp in microseconds."""


@dataclass(frozen=True)
class LastCall:
    """The last call into a stage of a run that did not finish."""

    stage: str
    use: str
    method: str
    at_s: float

    def __str__(self) -> str:
        return f"{self.method} of stage '{self.stage}' ({self.use}) at {self.at_s:.2f} s"


class ProgressFile:
    """Writes each call into the file before it is made; the system keeps it when the process dies.

    A folder in which it cannot be written goes without.
    """

    def __init__(self, folder: Path, uses: Mapping[str, str]) -> None:
        """Mark the calls into the stages ``uses``: what each one uses, by name."""
        self._path = folder / PROGRESS
        self._places = {name: place for place, name in enumerate(uses)}
        self._methods = {name: place for place, name in enumerate(_METHODS)}
        self._head = json.dumps(dict(uses)).encode() + b"\n"
        self._fd = -1
        with suppress(OSError):
            self._open()

    def mark(self, stage: str, method: str, utime: int) -> None:
        """Note that a method of a stage is called."""
        if self._fd >= 0:
            record = _RECORD.pack(self._places[stage], self._methods[method], utime)
            with suppress(OSError):
                write_at(self._fd, record, len(self._head))

    def remove(self) -> None:
        """Remove the file: the run has ended."""
        if self._fd >= 0:
            with suppress(OSError):
                self._path.unlink()
            os.close(self._fd)
            self._fd = -1
            with suppress(OSError):  # Windows removes no open file
                self._path.unlink(missing_ok=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.remove()

    def _open(self) -> None:
        fd = open_file(self._path, os.O_RDWR | os.O_CREAT | os.O_TRUNC)
        try:
            lock_file(fd)
            write_at(fd, self._head + bytes(_RECORD.size), 0)
        except OSError:
            os.close(fd)
            raise
        self._fd = fd

    @staticmethod
    def is_running(folder: Path) -> bool:
        """Whether a process still runs into a run folder."""
        return is_locked(folder / PROGRESS)

    @staticmethod
    def last_call(folder: Path) -> LastCall | None:
        """Return the last call into a stage of a run that did not finish, None if that is not known."""
        try:
            head, _, record = (folder / PROGRESS).read_bytes().partition(b"\n")
            uses = json.loads(head)
            stage, method, utime = _RECORD.unpack(record)
            if stage < 0 or not 0 < method < len(_METHODS) or utime < 0:
                return None
            name, use = list(uses.items())[stage]
            return LastCall(str(name), str(use), _METHODS[method], utime / 1e6)
        except (OSError, ValueError, RecursionError, AttributeError, struct.error, IndexError):
            return None
