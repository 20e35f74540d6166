"""Write files and folders under a temporary name, renamed when complete; files for libraries that ignore errors."""

from __future__ import annotations

import errno
import os
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from graphnav import GraphnavError, UserError, written_aside
from graphnav.core.machine import path_aside

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_ELSEWHERE = "choose another place with -o"
_READ_BYTES = 1 << 20


@contextmanager
def placed_file(target: Path, suffix: str, *, source: Path, force: bool) -> Iterator[Path]:
    """Yield a temporary path, ending in ``suffix``; it becomes ``target`` when the block ends without an error.

    ``source``: the exported log, which is never replaced.

    Raises
    ------
    UserError
        ``target`` is ``source``, exists without ``force``, or is not writable.
    GraphnavError
        Writing fails; nothing is left behind.
    """
    if target.is_dir():
        raise UserError.of(f"{target} is a folder", "name a file with -o")
    _refuse_source(target, source)
    if target.exists() and not force:
        raise UserError.of(f"{target} exists", "add --force to replace it, or choose another name with -o")
    with _writable(target):
        target.parent.mkdir(parents=True, exist_ok=True)
    with _on_disk(target), written_aside(target, suffix) as aside:
        with _writable(target):
            aside.touch()
        yield aside


@contextmanager
def placed_folder(target: Path, *, source: Path, force: bool) -> Iterator[Path]:
    """Yield a temporary folder; its files are moved to ``target`` when the block ends without an error.

    With ``force`` they replace files of the same names in an existing folder; others stay. ``source``: the exported
    log, which is never replaced.

    Raises
    ------
    UserError
        ``target`` is a file, is not empty without ``force``, or is not writable.
    GraphnavError
        Writing fails; nothing is left behind.
    """
    if target.exists() and not target.is_dir():
        raise UserError.of(f"{target} is a file", "name a folder with -o, or one channel with --channel")
    aside = path_aside(target)
    try:
        with _writable(target):
            if target.exists() and any(target.iterdir()) and not force:
                raise UserError.of(
                    f"{target} is not empty", "add --force to write into it, or choose another folder with -o"
                )
            aside.mkdir(parents=True)
        with _on_disk(target):
            yield aside
            if not target.exists():
                aside.rename(target)
                return
            files = sorted(aside.iterdir())
            for file in files:
                _refuse_source(target / file.name, source)
            for file in files:
                file.replace(target / file.name)
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _refuse_source(target: Path, source: Path) -> None:
    if target.exists() and target.samefile(source):
        raise UserError.of(f"{target} is the log to export", _ELSEWHERE)


@contextmanager
def _writable(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        if error.errno in _FULL:
            raise GraphnavError(f"cannot write {target}: {error.strerror}\n  make room, or {_ELSEWHERE}") from error
        reason = os.strerror(errno.ENOTDIR) if isinstance(error, FileExistsError) else error.strerror
        raise UserError.of(f"cannot write {target}: {reason}", _ELSEWHERE) from error


@contextmanager
def _on_disk(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise GraphnavError(
            f"cannot write {target}: {error.strerror or error}\n  make room, or {_ELSEWHERE}"
        ) from error


class QuietFile:
    """A writable binary file, for libraries that ignore write errors.

    After the first error it discards all data; `check` raises that error.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self._error: OSError | None = None
        self._at = self._size = 0

    def write(self, data: Any) -> int:
        """Write all bytes, or keep the error; return the number of bytes."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while self._error is None and done < len(view):
                done += self._file.write(view[done:])
        except OSError as error:
            self._error = error
        self._at += len(view)
        self._size = max(self._size, self._at)
        return len(view)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Seek, as if all writes had succeeded; return the position."""
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        if self._error is None:
            self._file.seek(self._at)
        return self._at

    def flush(self) -> None:
        """Do nothing: the file is not buffered."""

    def check(self) -> None:
        """Raise the first error, OSError, if there was one."""
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        """Close, and raise the first error."""
        self._file.close()
        self.check()


class PipedFile:
    """Copies the data written to the pipe ``path`` to ``file``; the writer must not seek.

    For libraries that write only to paths, and hang on a full disk.

    Call `opened` as soon as the library has opened the path, and `close` when it has closed it.
    """

    def __init__(self, file: Path) -> None:
        self._file = QuietFile(file)
        self._reading, self._writing = os.pipe()
        self.path = f"/dev/fd/{self._writing}"
        self._thread = threading.Thread(target=self._empty, name="graphnav export", daemon=True)
        self._thread.start()

    def opened(self) -> None:
        """Close our writing end, so that the end of the data is detected when the library closes its own."""
        os.close(self._writing)

    def check(self) -> None:
        """Raise the first write error, OSError, if there was one."""
        self._file.check()

    def close(self) -> None:
        """Wait for the remaining data, close the file, and raise the first error."""
        self._thread.join()
        os.close(self._reading)
        self._file.close()

    def _empty(self) -> None:
        while data := os.read(self._reading, _READ_BYTES):
            self._file.write(data)
