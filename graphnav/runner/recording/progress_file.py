"""Mark in the run folder which stage is called, so that a run whose process died can tell."""

from __future__ import annotations

import fcntl
import json
import mmap
import os
import struct
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

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
    """Writes each call into shared memory of the file, which survives the process; a call costs no system call.

    A folder in which it cannot be made goes without.
    """

    def __init__(self, folder: Path, uses: Mapping[str, str]) -> None:
        """Mark the calls into the stages ``uses``: what each one uses, by name."""
        self._path = folder / PROGRESS
        self._fd = -1
        self._memory: mmap.mmap | bytearray = bytearray(_RECORD.size)
        self._places = {name: place for place, name in enumerate(uses)}
        self._methods = {name: place for place, name in enumerate(_METHODS)}
        head = json.dumps(dict(uses)).encode() + b"\n"
        self._at = len(head)
        with suppress(OSError):
            self._open(head + bytes(_RECORD.size))
        if self._fd < 0:
            self._at = 0

    def mark(self, stage: str, method: str, utime: int) -> None:
        """Note that a method of a stage is called."""
        _RECORD.pack_into(self._memory, self._at, self._places[stage], self._methods[method], utime)

    def remove(self) -> None:
        """Remove the file: the run has ended."""
        if self._fd >= 0:
            with suppress(OSError):
                self._path.unlink()
            os.close(self._fd)
            self._fd = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.remove()

    def _open(self, content: bytes) -> None:
        fd = os.open(self._path, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o666)
        try:
            fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.write(fd, content) == len(content):  # memory without blocks of the disk would be a SIGBUS later
                self._memory = mmap.mmap(fd, len(content))
                self._fd = fd
        finally:
            if self._fd < 0:
                os.close(fd)


def is_running(folder: Path) -> bool:
    """Whether a process still runs into a run folder."""
    try:
        with (folder / PROGRESS).open("rb") as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


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
