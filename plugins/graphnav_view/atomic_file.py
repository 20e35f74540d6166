"""A picture is written under another name first: what has the final name is complete."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from uuid import uuid4


@contextmanager
def written_aside(path: Path) -> Iterator[Path]:
    """Yield a path with the suffix of ``path`` to write to; it becomes ``path`` if the block ends without an error.

    Otherwise what was written is removed, and what ``path`` held before stays.
    """
    aside = path.with_name(f".drawing-{uuid4().hex[:12]}{path.suffix}")
    try:
        yield aside
        aside.replace(path)
    finally:
        with suppress(OSError):  # it is there no more, or never was
            aside.unlink()
