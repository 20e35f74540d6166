"""Choose and create the folder of a run."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from graphnav.core.errors import UserError


def make_run_folder(wanted: Path | None, graph_name: str) -> Path:
    """Return a new or empty folder: ``wanted``, else ``runs/<graph>-<time>``.

    Raises
    ------
    UserError
        ``wanted`` is not empty, not a folder, or cannot be created.
    """
    folder = wanted or _unused(Path("runs") / f"{graph_name}-{time.strftime('%Y%m%d-%H%M%S')}")
    try:
        if folder.exists() and not folder.is_dir():
            raise UserError.of(f"{folder} is a file", "choose another folder with -o")
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise UserError.of(f"{folder} is not empty", "choose another folder with -o, or remove this one")
    except OSError as error:
        raise UserError.of(f"cannot create {folder}: {error.strerror}", "choose another folder with -o") from error
    return folder


@contextmanager
def removed_if_empty(folder: Path) -> Iterator[None]:
    """Remove the folder if the block has written nothing into it, as when a run does not start."""
    try:
        yield
    finally:
        with suppress(OSError):  # it is not empty
            folder.rmdir()


def _unused(folder: Path) -> Path:
    """Return ``folder``, with a number appended if a run of the same second has taken it."""
    number, candidate = 1, folder
    while candidate.exists():
        number += 1
        candidate = folder.with_name(f"{folder.name}-{number}")
    return candidate
