"""Work in the folder of a tuning: one process at a time, what a killed one left is removed."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graphnav.errors import UserError

_LOCK = ".lock"
_SCRATCH = ".scratch"


@contextmanager
def work_in(folder: Path) -> Iterator[Path]:
    """Lock an existing folder and yield an empty one in it for what is not finished; it is removed at the end.

    Raises
    ------
    UserError
        Another process works in the folder, or it cannot be written.
    """
    scratch = folder / _SCRATCH
    try:
        lock = os.open(folder / _LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
    except OSError as error:
        raise UserError.of(f"cannot work in {folder}: {error.strerror}", "choose another folder with -o") from error
    try:
        _lock(lock, folder)
        shutil.rmtree(scratch, ignore_errors=True)
        scratch.mkdir()
        try:
            yield scratch
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
    finally:
        os.close(lock)


def _lock(lock: int, folder: Path) -> None:
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        hint = "wait for it, or choose another folder with -o"
        raise UserError.of(f"another 'graphnav tune' is at work in {folder}", hint) from error
