"""Threads: one per process for numerics, and those that plugins leave running."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Collection
from contextlib import suppress

from graphnav.core.errors import shown_name

ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "OPENCV_FOR_THREADS_NUM": "1",
}
"""The environment of a single-threaded process; it must be set before numpy and OpenCV are loaded."""
_PATIENCE_S = 1.0


def end_despite_threads(status: int) -> None:
    """End the process with an exit status if there are threads for which Python would wait; say which they are.

    Threads of executors, which end when they are idle, are left to Python. Returns if there are no others.
    """
    end_s = time.monotonic() + _PATIENCE_S
    for thread in _waited_for():
        thread.join(max(0.0, end_s - time.monotonic()))
    names = [shown_name(thread.name) for thread in _waited_for()]
    if not names:
        return
    with suppress(OSError, ValueError, AttributeError):
        print(f"ended with threads that a plugin left running: {', '.join(names)}", file=sys.stderr)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):
            stream.flush()
    os._exit(status)


def _waited_for() -> Collection[threading.Thread]:
    """Return the threads that Python joins when it ends, except idle ones of executors."""
    executors = sys.modules.get("concurrent.futures.thread")
    idle = set(getattr(executors, "_threads_queues", ()))
    return [t for t in threading.enumerate() if t is not threading.main_thread() and not t.daemon and t not in idle]
