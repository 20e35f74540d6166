"""Read regular files of a bounded size, and write files atomically.

No FIFO, device or mistaken file keeps a command waiting or takes its memory. Errors of reading are `OSError`, whose
``strerror`` says what is wrong, so that they are handled where other failures are. Readers of what is written find a
complete file, whenever the writer is stopped.
"""

from __future__ import annotations

import errno
import json
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from uuid import uuid4

from graphnav.core.errors import GraphnavError
from graphnav.core.machine.system import open_file

MAX_JSON_BYTES = 256 * 1024**2
"""Of plans and summaries: a plan of ten thousand runs has a few megabytes."""

_KINDS = (
    (stat.S_ISDIR, "Is a directory"),
    (stat.S_ISFIFO, "it is a FIFO, not a regular file"),
    (stat.S_ISSOCK, "it is a socket, not a regular file"),
)


def open_regular(path: Path) -> int:
    """Return a descriptor to read a regular file, which must be closed.

    Raises
    ------
    OSError
        It cannot be opened, or is not a regular file.
    """
    _check_kind(path, os.stat(path).st_mode)  # before it is opened, since opening a device may act on it
    found = open_file(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0))  # Windows has no file that makes wait
    try:
        _check_kind(path, os.fstat(found).st_mode)
    except OSError:
        os.close(found)
        raise
    return found


def read_regular(path: Path, max_bytes: int) -> bytes:
    """Return the bytes of a regular file.

    Raises
    ------
    OSError
        It cannot be read, is not a regular file, or has more than ``max_bytes``.
    """
    with os.fdopen(open_regular(path), "rb") as file:
        n_bytes = os.fstat(file.fileno()).st_size
        data = b"" if n_bytes > max_bytes else file.read(max_bytes + 1)
    if max(n_bytes, len(data)) > max_bytes:
        what = f"it has {max(n_bytes, len(data))} bytes, more than the maximum of {max_bytes}"
        raise OSError(errno.EFBIG, what, str(path))
    return data


def is_own(path: Path) -> bool:
    """Return whether only this user may write a file or folder; raises OSError if it cannot be looked up.

    Windows tells no owner in this way: there the folders of a user are taken to be the user's own, as they are made.
    """
    found = path.stat()
    if not hasattr(os, "geteuid"):
        return True
    return found.st_uid == os.geteuid() and not found.st_mode & 0o022


def read_json(path: Path) -> Any:
    """Return the content of a JSON file of at most `MAX_JSON_BYTES`.

    Raises
    ------
    OSError
        As of `read_regular`.
    ValueError
        It is not JSON in UTF-8, is nested too deeply, or has half of a surrogate pair, which cannot be written again.
    """
    try:
        found = json.loads(read_regular(path, MAX_JSON_BYTES).decode("utf-8"))
        json.dumps(found, ensure_ascii=False).encode("utf-8")
    except RecursionError as error:
        raise ValueError(f"{path} is nested too deeply") from error
    return found


def _check_kind(path: Path, mode: int) -> None:
    if stat.S_ISREG(mode):
        return
    text = next((text for is_kind, text in _KINDS if is_kind(mode)), "it is a device, not a regular file")
    raise OSError(errno.EISDIR if stat.S_ISDIR(mode) else errno.EINVAL, text, str(path))


@contextmanager
def written_aside(path: Path, suffix: str | None = None) -> Iterator[Path]:
    """Yield a path in the same folder to write to; it becomes ``path`` if the block ends without an error.

    Otherwise it is removed, and an existing ``path`` is unchanged. It ends in ``suffix``, by default that of ``path``.
    """
    aside = path_aside(path, path.suffix if suffix is None else suffix)
    try:
        yield aside
        aside.replace(path)
    finally:
        with suppress(OSError):  # it does not exist
            aside.unlink()


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a temporary file in the same folder, then rename it; strings as UTF-8.

    Raises
    ------
    GraphnavError
        The disk refuses; an existing file is unchanged.
    """
    try:
        with written_aside(path) as aside, aside.open("wb") as file:
            file.write(content.encode("utf-8") if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        raise GraphnavError(f"cannot write {path}: {error.strerror}") from error


def path_aside(path: Path, suffix: str = "") -> Path:
    """Return a unique name in the folder of ``path`` for what is not complete."""
    return path.with_name(f".unfinished-{uuid4().hex[:12]}{suffix}")
