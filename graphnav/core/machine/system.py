"""Differences between systems: locks, descriptors, and the features of Linux alone."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from graphnav.core.errors import UserError

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

_NAMES = {"win32": "Windows", "darwin": "macOS"}
_LOCKED_AT = 1 << 30
"""Windows locks bytes, and keeps other processes from reading them: one behind the end of any file that is locked."""
_MOVING = threading.Lock()
"""Held while a descriptor is moved to read or write where Windows has no call that does both."""


def is_linux() -> bool:
    """Whether this system is Linux."""
    return sys.platform == "linux"


def system_name() -> str:
    """Return the name of this system for a message."""
    return _NAMES.get(sys.platform, sys.platform)


def require_linux(what: str) -> None:
    """Raise UserError on another system; ``what`` with its verb: "live runs work"."""
    if not is_linux():
        hint = "simulation, studies, replay, figures and export work here"
        raise UserError.of(f"{what} on Linux only, and this is {system_name()}", hint)


def open_file(path: Path | str, flags: int, mode: int = 0o666) -> int:
    """Return a descriptor of a file, which processes that are started do not inherit; its bytes are as written.

    ``flags``: those of `os.open`; on Windows, where files may be text, the file is binary.
    """
    return os.open(path, flags | getattr(os, "O_BINARY", 0), mode)


def lock_file(fd: int, *, waits: bool = False, is_shared: bool = False) -> None:
    """Lock a file for this process until its descriptor is closed; the system ends the lock with the process.

    ``waits``: for another process that has the lock. ``is_shared``: beside other shared locks; on Windows for itself.

    Raises
    ------
    BlockingIOError
        Another process has the lock.
    OSError
        The file system has no locks, or on Windows another process has had the lock for 10 seconds.
    """
    if sys.platform == "win32":
        at = os.lseek(fd, 0, os.SEEK_CUR)
        os.lseek(fd, _LOCKED_AT, os.SEEK_SET)
        try:
            msvcrt.locking(fd, msvcrt.LK_LOCK if waits else msvcrt.LK_NBLCK, 1)
        except PermissionError as error:
            raise BlockingIOError(error.errno, error.strerror) from error
        finally:
            os.lseek(fd, at, os.SEEK_SET)
    else:
        kind = fcntl.LOCK_SH if is_shared else fcntl.LOCK_EX
        fcntl.flock(fd, kind if waits else kind | fcntl.LOCK_NB)


def is_locked(path: Path) -> bool:
    """Whether a process has locked a file."""
    try:
        with path.open("rb") as file:
            lock_file(file.fileno(), is_shared=True)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


def read_at(fd: int, n_bytes: int, at: int) -> bytes:
    """Return bytes of a file from a position, fewer at its end."""
    if hasattr(os, "pread"):
        return os.pread(fd, n_bytes, at)
    with _MOVING:
        os.lseek(fd, at, os.SEEK_SET)
        return os.read(fd, n_bytes)


def write_at(fd: int, data: bytes, at: int) -> None:
    """Write a few bytes at a position of a file; the position of the descriptor is undefined afterwards."""
    if hasattr(os, "pwrite"):
        os.pwrite(fd, data, at)
        return
    with _MOVING:
        os.lseek(fd, at, os.SEEK_SET)
        os.write(fd, data)


def write_some(fd: int, buffers: Sequence[bytes]) -> int:
    """Write buffers one after another in one call; return the number of bytes written, which may be less than all."""
    return os.writev(fd, buffers) if hasattr(os, "writev") else os.write(fd, b"".join(buffers))
