"""A process that makes one run after another, so that a stage that crashes takes nothing else with it."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from multiprocessing.connection import Pipe
from pathlib import Path

from graphnav.core.machine.single_thread import ONE_THREAD
from graphnav.studies.ablation import worker
from graphnav.studies.ablation.execution.crashed_run import died_result
from graphnav.studies.ablation.worker import IDLE_S, Result, Task


class WorkerProcess:
    """The process as its parent sees it. It ends when told, when idle, and with its parent, however that ends."""

    def __init__(self) -> None:
        self.connection, theirs = Pipe()
        command = [sys.executable, "-P", "-m", worker.__name__, str(theirs.fileno())]
        old = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # Ctrl-C is the parent's to answer
        try:
            self._process = subprocess.Popen(  # noqa: S603 - it is this program
                command, env=os.environ | ONE_THREAD, stdin=subprocess.DEVNULL, stdout=2, pass_fds=[theirs.fileno()]
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, old)
            theirs.close()
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

    def perform(self, task: Task, scratch: str) -> Result:
        """Let it make a run; ``died`` is set if the process did not survive."""
        self.send(task, scratch)
        return self.receive() or died_result(task, Path(scratch))

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self._process.wait()
        self.connection.close()
