"""A folder that one process at a time works in; what a killed one left unfinished is removed."""

from __future__ import annotations

import fcntl
import os
import shutil
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.core.errors import UserError

_LOCK = ".lock"
_SCRATCH = ".scratch"
_OURS = {_LOCK, _SCRATCH}
"""Files that may exist before the record."""

_ELSEWHERE = "choose another folder with -o"


class LockedFolder:
    """A folder of a command, which it makes where there is none; the kernel releases the lock of a killed process.

    ``record``: the file that tells what was begun in it. ``noun``: what that is.

    Raises
    ------
    UserError
        It cannot be created or written, holds files but no record, or is in use by another process.
    """

    def __init__(self, path: Path, record: str, noun: str, command: str) -> None:
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not (path / record).exists() and (others := sorted({p.name for p in path.iterdir()} - _OURS)):
                raise UserError.of(f"{path} holds {others[0]}, but no {noun} ({record})", _ELSEWHERE)
            self._lock = os.open(path / _LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except FileExistsError as error:
            raise UserError.of(f"{path} is a file", _ELSEWHERE) from error
        except OSError as error:
            raise UserError.of(f"cannot work in {path}: {error.strerror}", _ELSEWHERE) from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._lock)
            what = f"another '{command}' is at work in {path}"
            raise UserError.of(what, f"wait for it, or {_ELSEWHERE}") from error

    @property
    def scratch(self) -> Path:
        """Where files are that are not complete; removed at the end."""
        return self.path / _SCRATCH

    def empty_scratch(self) -> None:
        """Make the scratch folder, without what a killed process left."""
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        shutil.rmtree(self.scratch, ignore_errors=True)
        os.close(self._lock)
