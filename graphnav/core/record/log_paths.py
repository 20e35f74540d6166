"""Find a log by the path of its file or of its run folder, and the files that it is split into."""

from __future__ import annotations

import re
from pathlib import Path

from graphnav.core.errors import UserError
from graphnav.core.record.bags import is_bag
from graphnav.core.run_folder import RunFolder


def find_log(path: Path, hint: str = "name a run folder or a log") -> Path:
    """Return the log at ``path`` or in the folder ``path``; a ROS 2 bag in a folder is that folder.

    Raises
    ------
    UserError
        The log does not exist; the error's hint is ``hint``.
    """
    if is_bag(path):
        return path
    log = path / RunFolder.LOG if path.is_dir() else path
    if not log.is_file():
        raise UserError.of(f"{path} holds no {RunFolder.LOG}" if path.is_dir() else f"there is no {path}", hint)
    return log


def numbered(path: Path, number: int) -> Path:
    """Return the name of the ``number``-th file of a recording: ``drive.0003.lcmlog``."""
    return path.with_name(f"{path.stem}.{number:04}{path.suffix}")


def files_of(path: Path) -> list[Path]:
    """Return the existing files of a split recording, by number."""
    name = re.compile(rf"{re.escape(path.stem)}\.[0-9]{{4,}}{re.escape(path.suffix)}")
    found = (file for file in path.parent.glob("*") if name.fullmatch(file.name))
    return sorted(found, key=lambda file: (len(file.name), file.name))  # number 10000 has a digit more


def parts_of(log: Path) -> list[Path]:
    """Return the files of a log, oldest first: that of a run may be ``run.lcmlog``, ``run.0001.lcmlog`` and so on."""
    first, *others = [numbered(log, 0), *files_of(log)] if log.name == RunFolder.LOG else [log]
    return [log] if first in others else [log, *others]
