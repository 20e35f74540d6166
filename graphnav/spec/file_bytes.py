"""Read the bytes of a YAML file, bounded."""

from __future__ import annotations

from pathlib import Path

from graphnav.errors import Place, UserError
from graphnav.spec.yaml import MAX_BYTES


def read_bytes(path: Path, place: Place, who: str = "it") -> bytes:
    """Return what a file holds, or one byte more than it may have; ``who``: what errors call it.

    Raises
    ------
    UserError
        It cannot be read; said at ``place``.
    """
    try:
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UserError.of(f"{who} cannot be read: {error.strerror}", place=place) from error
