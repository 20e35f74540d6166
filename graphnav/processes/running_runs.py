"""Runs of this user that are running, and the processes of their stages."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from graphnav import UserError, did_you_mean
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import RunningRun
from graphnav.processes.warden import marks_of


class RunningProcess(NamedTuple):
    """A process of the stages of a run."""

    name: str
    pid: int
    restarts: int


def run_named(name: str | None) -> RunningRun:
    """Return the running run of an id or a folder; None for the only one.

    Raises
    ------
    UserError
        There is none, or there are several.
    """
    running = RunningRun.all()
    ids = [run.run_id for run in running]
    if name is None:
        if len(running) == 1:
            return running[0]
        hint = f"name one of {', '.join(ids)}" if running else "'graphnav ps' lists those of this user"
        raise UserError.of(f"{len(running)} runs are running" if running else "no run is running", hint)
    folder = Path(name).absolute()
    found = next((run for run in running if run.run_id == name or run.folder == folder), None)
    if found is None:
        raise UserError.of(f"no run '{name}' is running", did_you_mean(name, ids) or "'graphnav ps' lists them")
    return found


def folder_named(name: str | None) -> tuple[Path, RunningRun | None]:
    """Return the folder of a run that is running or ended, by its id or as it is, and the run if it is running.

    Raises
    ------
    UserError
        There is none.
    """
    if name is not None and Path(name).is_dir():
        folder = Path(name).absolute()
        return folder, next((run for run in RunningRun.all() if run.folder == folder), None)
    run = run_named(name)
    return run.folder, run


def processes_of(run: RunningRun) -> list[RunningProcess]:
    """Return the processes of the stages of a run, by name."""
    found = []
    for path in Path("/proc").glob("[0-9]*"):
        pid = int(path.name)
        marks = marks_of(pid) if _parent_of(pid) == run.pid else []
        if marks:
            _, name, epoch = marks[-1].split("/")
            found.append(RunningProcess(name, pid, int(epoch) - 1))
    return sorted(found)


def output_files(folder: Path) -> dict[Path, str]:
    """Return the files of a run folder with what was printed, and what stands before their lines."""
    if (folder / RunFolder.PRINTED).exists():
        return {folder / RunFolder.PRINTED: ""}
    return {path: f"[{path.stem}] " for path in sorted((folder / RunFolder.OUTPUT).glob("*.txt"))}


def _parent_of(pid: int) -> int:
    try:
        return int(Path(f"/proc/{pid}/stat").read_text(errors="replace").rpartition(") ")[2].split()[1])
    except (OSError, ValueError, IndexError):
        return 0
