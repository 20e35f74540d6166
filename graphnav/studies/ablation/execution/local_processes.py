"""Make runs in parallel by processes of this machine."""

from __future__ import annotations

import shutil
from collections import deque
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import wait
from pathlib import Path
from tempfile import mkdtemp

from graphnav.core.errors import GraphnavError
from graphnav.studies.ablation.execution.crashed_run import died_result
from graphnav.studies.ablation.execution.task_queue import TaskQueue
from graphnav.studies.ablation.execution.worker_process import WorkerProcess
from graphnav.studies.ablation.worker import Result, Task

_Begun = deque[tuple[Task, str]]
"""The tasks of a process, the one that it makes first, each with the folder in which it is made."""

_AHEAD = 2
"""Tasks of a process: the one that it makes, and the next one, so that it need not wait while results are kept."""


class LocalWorkers:
    """Processes of this machine, started when needed and reused; they make runs in folders below ``scratch``."""

    def __init__(self, jobs: int, scratch: Path) -> None:
        self.at_once = jobs
        self._scratch = scratch
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
        result = result or died_result(task, Path(folder))
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
