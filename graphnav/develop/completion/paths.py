"""Files and run folders of the working folder, as far as a prefix leads."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

RUN_LOG = "run.lcmlog"
"""The file by which a folder is a run folder."""
_RUNS = "runs"
_MAX_RUNS = 20


def paths(prefix: str, suffixes: Sequence[str] = ()) -> Iterator[str]:
    """Yield folders (with a slash behind) and the files with one of ``suffixes``, or all."""
    folder, slash, start = prefix.rpartition("/")
    with suppress(OSError):
        for path in sorted(Path(os.path.expanduser(folder + slash or ".")).iterdir()):
            if not path.name.startswith(start) or (path.name.startswith(".") and not start):
                continue
            if path.is_dir():
                yield f"{folder}{slash}{path.name}/"
            elif not suffixes or path.suffix in suffixes:
                yield f"{folder}{slash}{path.name}"


def run_folders(prefix: str) -> Iterator[str]:
    """Yield run folders, the newest of ``runs/`` first, then other folders and logs."""
    newest: list[str] = []
    with suppress(OSError):
        found = [path.parent for path in Path(_RUNS).glob(f"*/{RUN_LOG}")]
        newest = list(map(str, sorted(found, key=lambda path: path.stat().st_mtime, reverse=True)[:_MAX_RUNS]))
    yield from newest
    for path in paths(prefix, (".lcmlog",)):
        folder = path.rstrip("/")
        if folder not in newest:
            yield folder if path != folder and Path(folder, RUN_LOG).is_file() else path
