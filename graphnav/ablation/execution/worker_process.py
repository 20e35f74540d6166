"""A process that makes runs one after another, so that a stage that crashes takes nothing else with it."""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import threading
import time
import traceback
from multiprocessing.connection import Connection, Pipe
from pathlib import Path

from graphnav.single_thread import ONE_THREAD
from graphnav.ablation.worker.perform_task import Result, Task, perform

IDLE_S = 60.0
"""After so long without work a process ends itself: on a cluster nobody else tells it that the study is over."""


class Child:
    """The process as its parent sees it. It ends when told, when idle, and with its parent, however that ends."""

    def __init__(self) -> None:
        self._connection, theirs = Pipe()
        command = [sys.executable, "-P", "-m", __name__, str(theirs.fileno())]
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

    def perform(self, task: Task, scratch: str) -> Result:
        """Let it make a run; ``died`` says that it did not survive."""
        try:
            self._connection.send((task, scratch))
            result: Result = self._connection.recv()
        except (EOFError, OSError):
            return Result(task, {}, died=True)
        self._used_s = time.monotonic()
        return result

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()
        self._process.wait()


def main() -> None:
    """Make the runs that the parent asks for."""
    connection = Connection(int(sys.argv[1]))
    threading.Thread(target=_end_with_parent, args=(connection.fileno(),), daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while connection.poll(IDLE_S):
            task, scratch = connection.recv()
            connection.send(_perform(task, Path(scratch)))


def _perform(task: Task, scratch: Path) -> Result:
    try:
        return perform(task, scratch)
    except Exception as error:  # noqa: BLE001 - the parent must hear of it, and its user see where
        traceback.print_exc()
        return Result(task, {}, trouble=f"{type(error).__name__}: {error}")


def _end_with_parent(fd: int) -> None:
    poll = select.poll()
    poll.register(fd, 0)  # no event but that the other end is closed
    poll.poll()
    os._exit(1)


if __name__ == "__main__":
    main()
