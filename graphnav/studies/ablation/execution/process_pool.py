"""The worker processes of one machine: started when needed, reused, ended together."""

from __future__ import annotations

import tempfile
import threading
from pathlib import Path

from graphnav.studies.ablation.execution.worker_process import WorkerProcess
from graphnav.studies.ablation.worker import Result, Task


class ProcessPool:
    """Makes runs, as many at once as threads ask for one; each is made in a folder of its own below ``scratch``."""

    def __init__(self, scratch: Path | None = None) -> None:
        self._scratch = scratch
        self._lock = threading.Lock()
        self._idle: list[WorkerProcess] = []
        self._busy: set[WorkerProcess] = set()
        self._is_closed = False

    def perform(self, task: Task) -> Result:
        """Make a run in a process that makes nothing else meanwhile."""
        try:
            with tempfile.TemporaryDirectory(dir=self._scratch, ignore_cleanup_errors=True) as scratch:
                return self._perform(task, scratch)
        except OSError as error:
            return Result(task, {}, error=f"cannot work in {self._scratch or tempfile.gettempdir()}: {error}")

    def close(self) -> None:
        """End all processes at once; what they were doing has died."""
        with self._lock:
            self._is_closed = True
            for child in (*self._idle, *self._busy):
                child.kill()

    def _perform(self, task: Task, scratch: str) -> Result:
        with self._lock:
            if self._is_closed:
                return Result(task, {}, died=True)
            child = self._take()
            self._busy.add(child)
        result = child.perform(task, scratch)
        with self._lock:
            self._busy.discard(child)
            if result.died or result.ends_process:
                child.kill()
            else:
                self._idle.append(child)
        return result

    def _take(self) -> WorkerProcess:
        while self._idle:
            child = self._idle.pop()
            if child.is_fresh:
                return child
            child.kill()
        return WorkerProcess()
