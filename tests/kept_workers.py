"""One pool of worker processes for all studies that a process of the tests makes: each takes a second to start."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from graphnav.studies.ablation.execution import local_processes
from graphnav.studies.ablation.execution.local_processes import WorkerProcess
from graphnav.studies.ablation.worker import Result, Task

_Surroundings = tuple[dict[str, str], int]


class KeptProcess(WorkerProcess):
    """A process that waits for the next study when one has no more to do for it."""

    def __init__(self, idle: list[KeptProcess]) -> None:
        self._idle = idle
        self._n_begun = 0
        self.began_in = _surroundings()
        super().__init__()

    def send(self, task: Task, scratch: str) -> None:
        """Count a run that is begun."""
        self._n_begun += 1
        super().send(task, scratch)

    def receive(self) -> Result | None:
        """Count a run that is finished; a process that then ends is never used again."""
        result = super().receive()
        if result is not None and not result.ends_process:
            self._n_begun -= 1
        return result

    def kill(self) -> None:
        """Keep it, unless it has a run to make or has died."""
        if self._n_begun or not self.is_fresh:
            self.end()
        else:
            self._idle.append(self)

    def end(self) -> None:
        """End it at once."""
        super().kill()


@contextmanager
def kept_workers() -> Iterator[None]:
    """Let studies use the processes of former ones while this is entered: those that have the same environment."""
    idle: list[KeptProcess] = []

    def start() -> KeptProcess:
        for process in [one for one in idle if not one.is_fresh]:
            idle.remove(process)
            process.end()
        alike = next((one for one in idle if one.began_in == _surroundings()), None)
        if alike is None:
            return KeptProcess(idle)
        idle.remove(alike)
        return alike

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(local_processes, "WorkerProcess", start)
        yield
    for process in idle:
        process.end()


def _surroundings() -> _Surroundings:
    """Return what a process inherits: the environment, and where it reports errors."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTEST_CURRENT_TEST"}
    return environment, os.fstat(2).st_ino
