"""Limit the size of received images."""

from __future__ import annotations

from graphnav import FieldError

MAX_PIXELS = 64_000_000
"""More than any robot camera has; a larger declared size is refused before memory is allocated."""


def check_size(rows: int, cols: int, of: str = "") -> None:
    """Raise FieldError unless a picture has at least one pixel and at most `MAX_PIXELS`; ``of``: begins its fields."""
    for name, size in (("height", rows), ("width", cols)):
        if size < 1:
            raise FieldError(f"{of}{name}", size, "1 or more")
    if rows * cols > MAX_PIXELS:
        raise FieldError(f"{of}width * height", f"{cols} * {rows}", f"{MAX_PIXELS // 10**6} million at most")
