"""Write a picture under a temporary name first, so that a file with the final name is complete."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """Yield a path with the suffix of ``path`` to write to; it becomes ``path`` if the block ends without an error.

    Otherwise it is removed, and the previous ``path`` is kept.
    """
    aside = path.with_name(f".drawing-{uuid4().hex[:12]}{path.suffix}")
    try:
        yield aside
        aside.replace(path)
    finally:
        with suppress(OSError):  # it does not exist
            aside.unlink()
