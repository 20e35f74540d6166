"""``python -m graphnav.studies.ablation.worker FD``: the process that makes the runs its parent asks for, in turn."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import traceback
from collections.abc import Callable
from pathlib import Path
from queue import Empty, SimpleQueue

if sys.platform == "win32":
    from multiprocessing.connection import PipeConnection as Connection
else:
    from multiprocessing.connection import Connection

from graphnav.core.errors import one_line
from graphnav.core.machine import escaped_output
from graphnav.studies.ablation.worker.perform_task import IDLE_S, Result, Task, perform


def serve(fd: int) -> None:
    """Make the runs that come through the connection ``fd`` until it is closed or nothing came for `IDLE_S`."""
    connection = Connection(fd)
    tasks: SimpleQueue[tuple[Task, str]] = SimpleQueue()
    threading.Thread(target=_receive, args=(connection, tasks), daemon=True).start()
    with contextlib.suppress(Empty, OSError), escaped_output():
        while True:
            task, scratch = tasks.get(timeout=IDLE_S)
            connection.send(_perform(task, Path(scratch), connection.send))


def _perform(task: Task, scratch: Path, send: Callable[[Result], None]) -> Result:
    try:
        return perform(task, scratch, send)
    except BaseException as error:  # noqa: BLE001 - the parent must hear of it, and its user see where
        traceback.print_exc()
        return Result(task, {}, error=one_line(error))


def _receive(connection: Connection, tasks: SimpleQueue[tuple[Task, str]]) -> None:
    """Receive tasks while others are performed; end the process at once when the other end is closed."""
    try:
        while True:
            tasks.put(connection.recv())
    except (EOFError, OSError):
        os._exit(1)
    except Exception:  # noqa: BLE001 - a thread that ends would leave the process waiting
        traceback.print_exc()
        os._exit(1)


serve(int(sys.argv[1]))
