"""Make runs in parallel by processes of this machine: started when needed, fed ahead, reused, ended together."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Hashable, Iterable, Iterator
from contextlib import contextmanager
from itertools import groupby
from multiprocessing.connection import Pipe, wait
from pathlib import Path
from tempfile import gettempdir, mkdtemp
from typing import Any

from graphnav import GraphnavError
from graphnav.core.machine import ONE_THREAD
from graphnav.core.runner import ProgressFile
from graphnav.studies.ablation import worker
from graphnav.studies.ablation.worker import IDLE_S, Result, Task

RUNS_IN_A_ROW = 4
"""Runs through one world that a process makes one after another: more would save little, and let a few variants of an
interrupted study be far ahead of the others."""


def in_rows(tasks: Iterable[Task], n_processes: int = 0) -> list[list[Task]]:
    """Return tasks in their order, those that one process is to make one after another together.

    ``n_processes``: where none takes over what another has not begun, so many of the last rows come as single tasks.
    """
    worlds = (list(group) for _, group in groupby(tasks, key=_world))
    rows = [world[first : first + RUNS_IN_A_ROW] for world in worlds for first in range(0, len(world), RUNS_IN_A_ROW)]
    n_shared = max(len(rows) - n_processes, 0)
    return rows[:n_shared] + [[task] for row in rows[n_shared:] for task in row]


class TaskQueue:
    """Hands out tasks in their order, several through one world to one process, until few are left."""

    def __init__(self, tasks: Iterable[Task]) -> None:
        self._groups = deque(map(deque, in_rows(tasks)))
        self._taken: dict[Hashable, deque[Task]] = {}

    def __len__(self) -> int:
        """Return the number of pending tasks."""
        return sum(map(len, (*self._groups, *self._taken.values())))

    def take(self, taker: Hashable) -> Task | None:
        """Return the next task of a process: of its world, of the next one, or what another has not begun."""
        own = self._taken.get(taker)
        if not own and self._groups:
            own = self._taken[taker] = self._groups.popleft()
        if not own:
            own = max(self._taken.values(), key=len, default=None)
        return own.popleft() if own else None

    def put_back(self, tasks: Iterable[Task]) -> None:
        """Add tasks that were not begun, as the next ones."""
        self._groups.extendleft(deque([task]) for task in tasks)


def _world(task: Task) -> Hashable:
    """Return what the runs through one world have in common."""
    return task.graph_path, task.seed


@contextmanager
def _apart(handle: int) -> Iterator[dict[str, Any]]:
    """Yield the options of a process that inherits ``handle``, and leaves Ctrl-C to its parent, while it is started."""
    if sys.platform == "win32":
        os.set_handle_inheritable(handle, True)  # noqa: FBT003 - it takes no name
        inherited = subprocess.STARTUPINFO(lpAttributeList={"handle_list": [handle]})
        yield {"startupinfo": inherited, "creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    else:
        old = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield {"pass_fds": [handle]}
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, old)


class WorkerProcess:
    """The process as its parent sees it. It ends when told, when idle, and with its parent, however that ends."""

    def __init__(self) -> None:
        self.connection, theirs = Pipe()
        command = [sys.executable, "-P", "-m", worker.__name__, str(theirs.fileno())]
        with contextlib.closing(theirs), _apart(theirs.fileno()) as options:
            self._process = subprocess.Popen(  # noqa: S603 - it is this program
                command, env=os.environ | ONE_THREAD, stdin=subprocess.DEVNULL, stdout=2, **options
            )
        self._used_s = time.monotonic()

    @property
    def is_fresh(self) -> bool:
        """Whether it surely still waits for work."""
        return self._process.poll() is None and time.monotonic() - self._used_s < IDLE_S / 2

    def send(self, task: Task, scratch: str) -> None:
        """Give it a run to make after those that it has; if it has died, `receive` notices."""
        with contextlib.suppress(OSError):
            self.connection.send((task, scratch))

    def receive(self) -> Result | None:
        """Wait for the result of the first run that it has; None if the process did not survive it."""
        try:
            result: Result = self.connection.recv()
        except (EOFError, OSError):
            return None
        self._used_s = time.monotonic()
        return result

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self._process.wait()
        self.connection.close()


_Begun = deque[tuple[Task, str]]
"""The tasks of a process, the one that it makes first, each with the folder in which it is made."""

_AHEAD = 2
"""Tasks of a process: the one that it makes, and the next one, so that it need not wait while results are kept."""


def _died_result(task: Task, scratch: Path) -> Result:
    """Return the result of a run whose process died; ``scratch`` is the folder in which it was made."""
    call = ProgressFile.last_call(scratch)
    return Result(task, {}, died=True, last_call=str(call) if call is not None else "")


class LocalWorkers:
    """Processes of this machine, started when needed and reused; they make runs in folders below ``scratch``."""

    def __init__(self, jobs: int, scratch: Path | None = None) -> None:
        self.at_once = jobs
        self._scratch = scratch or Path(gettempdir())
        self._processes: list[WorkerProcess] = []

    def perform_all(self, tasks: Iterable[Task], *, one_at_a_time: bool = False) -> Iterator[Result]:
        """Yield what comes of the tasks, in the order in which they are finished.

        Raises
        ------
        GraphnavError
            No folder can be created in ``scratch``.
        """
        queue = TaskQueue(tasks)
        processes = self._fresh(min(1 if one_at_a_time else self.at_once, len(queue)))
        begun: dict[WorkerProcess, _Begun] = {process: deque() for process in processes}
        for process in processes:
            self._feed(process, queue, begun)
        while busy := [process for process, own in begun.items() if own]:
            ready = wait([process.connection for process in busy])
            for process in busy:
                if process.connection in ready:
                    yield self._received(process, queue, begun)

    def close(self) -> None:
        """End all processes at once."""
        for process in self._processes:
            process.kill()
        self._processes.clear()

    def _fresh(self, count: int) -> list[WorkerProcess]:
        """Return this many processes that wait for work."""
        for process in [one for one in self._processes if not one.is_fresh]:
            self._end(process)
        self._processes += [WorkerProcess() for _ in range(count - len(self._processes))]
        return self._processes[:count]

    def _feed(self, process: WorkerProcess, queue: TaskQueue, begun: dict[WorkerProcess, _Begun]) -> None:
        """Give a process something to do, and more to follow unless the others would then run out of work sooner."""
        own = begun[process]
        while len(own) < (_AHEAD if len(queue) >= len(begun) else 1) and (task := queue.take(process)):
            try:
                folder = mkdtemp(dir=self._scratch)
            except OSError as error:
                raise GraphnavError(f"cannot work in {self._scratch}: {error}") from error
            own.append((task, folder))
            process.send(task, folder)

    def _received(self, process: WorkerProcess, queue: TaskQueue, begun: dict[WorkerProcess, _Begun]) -> Result:
        """Return the result that a process has; give it more to do, or its tasks to a new one if it has died."""
        result = process.receive()
        task, folder = begun[process].popleft()
        if result is None or result.ends_process:
            queue.put_back(later for later, _ in begun.pop(process))
            self._end(process)
            process = WorkerProcess()
            self._processes.append(process)
            begun[process] = deque()
        self._feed(process, queue, begun)
        result = result or _died_result(task, Path(folder))
        shutil.rmtree(folder, ignore_errors=True)
        return result

    def _end(self, process: WorkerProcess) -> None:
        self._processes.remove(process)
        process.kill()


@contextmanager
def local_workers(jobs: int, scratch: Path) -> Iterator[LocalWorkers]:
    """Make up to ``jobs`` runs at once here; on leaving all processes are ended."""
    workers = LocalWorkers(jobs, scratch)
    try:
        yield workers
    finally:
        workers.close()
