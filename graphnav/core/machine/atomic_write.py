"""Write a file atomically: readers find a complete one, whenever the writer is stopped."""

from __future__ import annotations

import os
from pathlib import Path

from graphnav.core.errors import GraphnavError


def write_atomically(path: Path, content: str | bytes) -> None:
    """Write a temporary file in the same folder, then rename it; strings as UTF-8.

    Raises
    ------
    GraphnavError
        The disk refuses; an existing file is unchanged.
    """
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with unfinished.open("wb") as file:
            file.write(content.encode("utf-8") if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
        unfinished.replace(path)
    except OSError as error:
        raise GraphnavError(f"cannot write {path}: {error.strerror}") from error
    finally:
        unfinished.unlink(missing_ok=True)
