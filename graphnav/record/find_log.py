"""Find a log by the path of its file or of its run folder."""

from __future__ import annotations

from pathlib import Path

from graphnav.errors import UserError
from graphnav.run_folder import LOG


def find_log(path: Path, hint: str = "name a run folder or a log") -> Path:
    """Return the log at ``path`` or in the folder ``path``.

    Raises
    ------
    UserError
        The log does not exist; the error's hint is ``hint``.
    """
    log = path / LOG if path.is_dir() else path
    if not log.is_file():
        raise UserError.of(f"{path} holds no {LOG}" if path.is_dir() else f"there is no {path}", hint)
    return log
