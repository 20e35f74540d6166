"""The folder of a study: locked, and every run in it complete."""

from __future__ import annotations

import fcntl
import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.ablation.plan import RUNS, Plan, check_compatible
from graphnav.errors import GraphnavError, UserError
from graphnav.runner.recording.run_recorded import SUMMARY

PLAN = "plan.json"
LOCK = ".lock"
SCRATCH = ".scratch"
_OURS = {LOCK, SCRATCH}
"""Files that may exist before the plan."""

_ELSEWHERE = "choose another folder with -o"


class StudyFolder:
    """The folder of a study, for one process at a time; makes it where there is none.

    A run is put together in a scratch folder and renamed into place, so that every existing one is complete. The kernel
    releases the lock of a process that is killed.

    Raises
    ------
    UserError
        It cannot be created or written, holds files but no study, or is in use by another process.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not (path / PLAN).exists() and (others := sorted({p.name for p in path.iterdir()} - _OURS)):
                raise UserError.of(f"{path} holds {others[0]}, but no study ({PLAN})", _ELSEWHERE)
            self._lock = os.open(path / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except FileExistsError as error:
            raise UserError.of(f"{path} is a file", _ELSEWHERE) from error
        except OSError as error:
            raise UserError.of(f"cannot work in {path}: {error.strerror}", _ELSEWHERE) from error
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            os.close(self._lock)
            what = f"another 'graphnav ablate' is at work in {path}"
            raise UserError.of(what, f"wait for it, or {_ELSEWHERE}") from error

    @property
    def scratch(self) -> Path:
        """Where runs are made; empty at the beginning, and removed at the end."""
        return self.path / SCRATCH

    def begin(self, plan: Plan) -> None:
        """Remove what a killed process left and write the plan.

        Raises
        ------
        UserError
            The folder holds another study, or runs that would not compare with those to come.
        """
        written = self.path / PLAN
        if written.exists():
            old = read_plan(self.path)
            if (self.path / RUNS).exists():
                check_compatible(old, plan, self.path)
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir()
        unfinished = self.scratch / PLAN
        plan.write(unfinished)
        unfinished.replace(written)

    def holds(self, place: str) -> bool:
        """Return whether ``place`` has a complete run."""
        return (self.path / place / SUMMARY).is_file()

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

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        shutil.rmtree(self.scratch, ignore_errors=True)
        os.close(self._lock)


def read_plan(folder: Path) -> Plan:
    """Return the plan of a study's folder.

    Raises
    ------
    UserError
        There is none, or it is not a plan.
    """
    path = folder / PLAN
    try:
        return Plan.read(path)
    except FileNotFoundError as error:
        raise UserError.of(
            f"{folder} is not the folder of a study: there is no {PLAN}", "name one that has it"
        ) from error
    except OSError as error:
        raise UserError.of(f"cannot read {path}: {error.strerror}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        hint = "it may be of another version of graphnav; choose another folder"
        raise UserError.of(f"{path} is not the plan of a study", hint) from error
