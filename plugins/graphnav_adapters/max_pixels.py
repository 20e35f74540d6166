"""Limit the size of received images."""

from __future__ import annotations

MAX_PIXELS = 64_000_000
"""More than any robot camera has; a larger declared size is refused before memory is allocated."""


def check_size(rows: int, cols: int) -> None:
    """Raise ValueError unless the picture has at least one pixel and at most `MAX_PIXELS`."""
    if rows < 1 or cols < 1:
        raise ValueError(f"a picture of {cols}x{rows} pixels has no pixels")
    if rows * cols > MAX_PIXELS:
        raise ValueError(f"a picture of {cols}x{rows} pixels is larger than {MAX_PIXELS // 10**6} million pixels")
