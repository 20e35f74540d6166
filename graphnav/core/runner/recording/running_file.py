"""Note a run in the user's state folder while it lasts, so that it can be listed, read and stopped."""

from __future__ import annotations

import json
import os
import time
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Self

from graphnav.core.machine.files import read_json
from graphnav.core.machine.system import is_linux, is_locked, lock_file, open_file
from graphnav.core.machine.user_folders import user_folder

_FOLDER = "running"
_SOCKET, _BEGUN = ".socket", ".begun"
_POLL_S, _PATIENCE_S = 0.02, 30.0
"""How often, and for how long, a begin is looked for: where the state folder is full it is never noted."""


@dataclass(frozen=True)
class RunningRun:
    """A run that a process of this user makes."""

    run_id: str
    pid: int
    graph: str
    folder: Path
    is_live: bool
    started_s: float
    """Unix time."""
    takes_changes: bool = False
    """Whether it listens on its `socket_path`."""

    @property
    def is_running(self) -> bool:
        """Whether it still runs."""
        path = _path(self.run_id)
        return path is not None and is_locked(path)

    @staticmethod
    def await_begin(run_id: str, pid: int) -> None:
        """Wait until a run is noted that a child of this process makes, until the child has ended, or for 30 s."""
        end_s = time.monotonic() + _PATIENCE_S
        while (path := _path(run_id)) and not is_locked(path) and time.monotonic() < end_s:
            if os.waitpid(pid, os.WNOHANG) != (0, 0):
                return
            time.sleep(_POLL_S)

    @staticmethod
    def socket_path(run_id: str) -> Path | None:
        """Return where a run listens, in a folder of this user alone; None where the user has no state folder."""
        path = _path(run_id)
        return None if path is None else path.with_suffix(_SOCKET)

    @staticmethod
    def all() -> list[RunningRun]:
        """Return all runs of this user on this machine, the oldest first; forget those whose process died."""
        folder = _folder()
        found = []
        for path in () if folder is None else folder.glob("*.json"):
            if not is_locked(path):
                for left in (path.with_suffix(_SOCKET), path):
                    with suppress(OSError):
                        left.unlink()
                continue
            with suppress(OSError, ValueError, TypeError, KeyError):
                said = read_json(path)
                found.append(RunningRun(**{**said, "folder": Path(said["folder"])}))
        return sorted(found, key=lambda run: run.started_s)


class RunningFile:
    """A context in which a run is noted, on Linux, where 'graphnav ps' works; not without a state folder."""

    def __init__(self, run_id: str, graph: str, folder: Path, *, is_live: bool, takes_changes: bool = False) -> None:
        self._run = RunningRun(run_id, os.getpid(), graph, folder.absolute(), is_live, time.time(), takes_changes)
        self._fd = -1

    def __enter__(self) -> Self:
        with suppress(OSError):
            self._write()
        return self

    def __exit__(self, *_: object) -> None:
        path = _path(self._run.run_id)
        if self._fd >= 0 and path is not None:
            with suppress(OSError):
                path.unlink()
            os.close(self._fd)

    def _write(self) -> None:
        path = _path(self._run.run_id)
        if path is None or not is_linux():
            return
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        # It appears under its name when it is complete and locked: readers delete what is not.
        begun = path.with_suffix(_BEGUN)
        fd = open_file(begun, os.O_RDWR | os.O_CREAT | os.O_TRUNC, 0o600)
        try:
            lock_file(fd)
            os.write(fd, json.dumps({**asdict(self._run), "folder": str(self._run.folder)}).encode())
            begun.rename(path)
        except OSError:
            begun.unlink(missing_ok=True)
            os.close(fd)
            raise
        self._fd = fd


def _folder() -> Path | None:
    state = user_folder("XDG_STATE_HOME")
    return None if state is None else state / _FOLDER


def _path(run_id: str) -> Path | None:
    folder = _folder()
    return None if folder is None else folder / f"{run_id}.json"
