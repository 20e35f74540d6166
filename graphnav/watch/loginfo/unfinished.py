"""Tell that the run of a log did not finish."""

from __future__ import annotations

from pathlib import Path

from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import ProgressFile


def unfinished(log: Path) -> str:
    """Return that the run of a log did not finish, and its last call into a stage as far as that is known.

    Empty if it finished, or if the log is not that of a run folder.
    """
    folder = log.parent
    if log.name != RunFolder.LOG or not (folder / RunFolder.GRAPH).is_file() or (folder / RunFolder.SUMMARY).is_file():
        return ""
    if ProgressFile.is_running(folder):
        return "the run has not finished: its process still runs"
    call = ProgressFile.last_call(folder)
    return "the run did not finish: its process ended early" + (
        f"; the last call was {call}" if call is not None else ""
    )
