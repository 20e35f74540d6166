"""Write a file atomically: readers find a complete one, whenever the writer is stopped."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4

from graphnav.core.errors import GraphnavError


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
