"""Write files and folders under a temporary name, and rename them when they are complete."""

from __future__ import annotations

import errno
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graphnav import GraphnavError, UserError, written_aside
from graphnav.core.machine import path_aside

_FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG}
_ELSEWHERE = "choose another place with -o"


@contextmanager
def placed_file(target: Path, suffix: str, *, source: Path, force: bool) -> Iterator[Path]:
    """Yield a temporary path, ending in ``suffix``; it becomes ``target`` when the block ends without an error.

    ``source``: the exported log, which is never replaced.

    Raises
    ------
    UserError
        ``target`` is ``source``, exists without ``force``, or is not writable.
    GraphnavError
        Writing fails; nothing is left behind.
    """
    if target.is_dir():
        raise UserError.of(f"{target} is a folder", "name a file with -o")
    _refuse_source(target, source)
    if target.exists() and not force:
        raise UserError.of(f"{target} exists", "add --force to replace it, or choose another name with -o")
    with _writable(target):
        target.parent.mkdir(parents=True, exist_ok=True)
    with _on_disk(target), written_aside(target, suffix) as aside:
        with _writable(target):
            aside.touch()
        yield aside


@contextmanager
def placed_folder(target: Path, *, source: Path, force: bool) -> Iterator[Path]:
    """Yield a temporary folder; its files are moved to ``target`` when the block ends without an error.

    With ``force`` they replace files of the same names in an existing folder; others stay. ``source``: the exported
    log, which is never replaced.

    Raises
    ------
    UserError
        ``target`` is a file, is not empty without ``force``, or is not writable.
    GraphnavError
        Writing fails; nothing is left behind.
    """
    if target.exists() and not target.is_dir():
        raise UserError.of(f"{target} is a file", "name a folder with -o, or one channel with --channel")
    aside = path_aside(target)
    try:
        with _writable(target):
            if target.exists() and any(target.iterdir()) and not force:
                raise UserError.of(
                    f"{target} is not empty", "add --force to write into it, or choose another folder with -o"
                )
            aside.mkdir(parents=True)
        with _on_disk(target):
            yield aside
            if not target.exists():
                aside.rename(target)
                return
            files = sorted(aside.iterdir())
            for file in files:
                _refuse_source(target / file.name, source)
            for file in files:
                file.replace(target / file.name)
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _refuse_source(target: Path, source: Path) -> None:
    if target.exists() and target.samefile(source):
        raise UserError.of(f"{target} is the log to export", _ELSEWHERE)


@contextmanager
def _writable(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        if error.errno in _FULL:
            raise GraphnavError(f"cannot write {target}: {error.strerror}\n  make room, or {_ELSEWHERE}") from error
        reason = os.strerror(errno.ENOTDIR) if isinstance(error, FileExistsError) else error.strerror
        raise UserError.of(f"cannot write {target}: {reason}", _ELSEWHERE) from error


@contextmanager
def _on_disk(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise GraphnavError(
            f"cannot write {target}: {error.strerror or error}\n  make room, or {_ELSEWHERE}"
        ) from error
