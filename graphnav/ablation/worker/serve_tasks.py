"""Make the runs that a parent process asks for, one after another."""

from __future__ import annotations

import contextlib
import os
import select
import threading
import traceback
from multiprocessing.connection import Connection
from pathlib import Path

from graphnav.ablation.worker.perform_task import perform
from graphnav.ablation.worker.task import Result, Task

IDLE_S = 60.0
"""A process that is idle for this long exits: on a cluster it is not notified of the end of the study."""


def serve(fd: int) -> None:
    """Make the runs that come through the connection ``fd`` until it is closed or nothing came for `IDLE_S`."""
    connection = Connection(fd)
    threading.Thread(target=_end_with_parent, args=(fd,), daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while connection.poll(IDLE_S):
            task, scratch = connection.recv()
            connection.send(_perform(task, Path(scratch)))


def _perform(task: Task, scratch: Path) -> Result:
    try:
        return perform(task, scratch)
    except Exception as error:  # noqa: BLE001 - the parent must hear of it, and its user see where
        traceback.print_exc()
        return Result(task, {}, error=f"{type(error).__name__}: {error}")


def _end_with_parent(fd: int) -> None:
    poll = select.poll()
    poll.register(fd, 0)  # no event but that the other end is closed
    poll.poll()
    os._exit(1)
