"""The folder of a study: locked, and every run in it complete."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav import GraphnavError, UserError
from graphnav.core.machine import lock_file, open_file
from graphnav.core.run_folder import RunFolder
from graphnav.core.runner import remember_copies
from graphnav.core.trust import Request, read_plugin
from graphnav.studies.ablation.plan import RUNS, Plan, check_compatible, load_plan, save_plan

_LOCK = ".lock"
_SCRATCH = ".scratch"
_OURS = {_LOCK, _SCRATCH}
"""Files that may exist before the record."""

_ELSEWHERE = "choose another folder with -o"


class LockedFolder:
    """A folder of a command, which it makes where there is none; the kernel releases the lock of a killed process.

    ``record``: the file that tells what was begun in it. ``noun``: what that is.

    Raises
    ------
    UserError
        It cannot be created or written, holds files but no record, or is in use by another process.
    """

    def __init__(self, path: Path, record: str, noun: str, command: str) -> None:
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not (path / record).exists() and (others := sorted({p.name for p in path.iterdir()} - _OURS)):
                raise UserError.of(f"{path} holds {others[0]}, but no {noun} ({record})", _ELSEWHERE)
            self._lock = open_file(path / _LOCK, os.O_RDWR | os.O_CREAT)
        except FileExistsError as error:
            raise UserError.of(f"{path} is a file", _ELSEWHERE) from error
        except OSError as error:
            raise UserError.of(f"cannot work in {path}: {error.strerror}", _ELSEWHERE) from error
        try:
            lock_file(self._lock)
        except BlockingIOError as error:
            os.close(self._lock)
            what = f"another '{command}' is at work in {path}"
            raise UserError.of(what, f"wait for it, or {_ELSEWHERE}") from error

    @property
    def scratch(self) -> Path:
        """Where files are that are not complete; removed at the end."""
        return self.path / _SCRATCH

    def empty_scratch(self) -> None:
        """Make the scratch folder, without what a killed process left."""
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        shutil.rmtree(self.scratch, ignore_errors=True)
        os.close(self._lock)


PLAN = "plan.json"


class StudyFolder(LockedFolder):
    """The folder of a study, for one process at a time; makes it where there is none.

    A run is put together in a scratch folder and renamed into place, so that every existing one is complete.

    Raises
    ------
    UserError
        It cannot be created or written, holds files but no study, or is in use by another process.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, PLAN, "study", "graphnav ablate")

    def begin(self, plan: Plan) -> None:
        """Remove what a killed process left and write the plan.

        Raises
        ------
        UserError
            The folder holds another study, or runs that would not compare with those to come.
        GraphnavError
            The disk refuses.
        """
        written = self.path / PLAN
        if written.exists():
            old = read_plan(self.path)
            if (self.path / RUNS).exists():
                check_compatible(old, plan, self.path)
        self.empty_scratch()
        save_plan(plan, written)
        _remember(self.path, plan)

    def holds(self, place: str) -> bool:
        """Return whether ``place`` has a complete run."""
        # Studies have many runs, for which pathlib is slow.
        return os.path.isfile(f"{self.path}/{place}/{RunFolder.SUMMARY}")

    def keep(self, place: str, files: Mapping[str, bytes]) -> None:
        """Put a run's files at ``place``: all of them or, where the process is killed or the disk full, none.

        Raises
        ------
        GraphnavError
            The disk refuses.
        """
        try:
            self._keep(place, files)
        except OSError as error:
            raise GraphnavError(f"cannot write into {self.path}: {error.strerror}") from error

    def _keep(self, place: str, files: Mapping[str, bytes]) -> None:
        unfinished = Path(tempfile.mkdtemp(dir=self.scratch))
        for name, content in files.items():
            (unfinished / name).parent.mkdir(parents=True, exist_ok=True)
            with (unfinished / name).open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
        unfinished.chmod(0o755)
        target = self.path / place
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists():
            shutil.rmtree(target)
        unfinished.rename(target)


def _remember(folder: Path, plan: Plan) -> None:
    """Remember the plugins of a study, and of each of its runs wherever they are made, as those of this user."""
    sources = {Path(plugin): read_plugin(Path(plugin)) for plugin in plan.plugins if os.path.isfile(plugin)}
    if sources:
        Request.of_plan(folder, sources).remember()
        remember_copies(list(sources))


def read_plan(folder: Path) -> Plan:
    """Return the plan of a study's folder.

    Raises
    ------
    UserError
        There is none, or it is not a plan.
    """
    path = folder / PLAN
    try:
        return load_plan(path)
    except FileNotFoundError as error:
        raise UserError.of(
            f"{folder} is not the folder of a study: there is no {PLAN}", "name one that has it"
        ) from error
    except OSError as error:
        raise UserError.of(f"cannot read {path}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError, UserError) as error:
        hint = "it may be of another version of graphnav; choose another folder"
        raise UserError.of(f"{path} is not the plan of a study", hint) from error
