"""Read the bytes of a YAML file, bounded."""

from __future__ import annotations

import errno
from pathlib import Path

from graphnav.core.errors import Place, UserError
from graphnav.core.machine.regular_file import read_regular
from graphnav.core.spec.yaml import MAX_BYTES, too_large


def read_bytes(path: Path, place: Place, who: str = "it") -> bytes:
    """Return the content of a YAML file; ``who``: the file as errors call it.

    Raises
    ------
    UserError
        It cannot be read, is not a regular file, or is larger than `MAX_BYTES`; shown at ``place``.
    """
    try:
        return read_regular(path, MAX_BYTES)
    except OSError as error:
        if error.errno == errno.EFBIG:
            raise too_large(path.stat().st_size, place, who) from error
        raise UserError.of(f"{who} cannot be read: {error.strerror}", place=place) from error
