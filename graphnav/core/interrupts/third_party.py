"""Run code of plugins outside of a run."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from graphnav.core.interrupts.ctrl_c import raise_ctrl_c

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def third_party_code() -> Iterator[None]:
    """Run code of a plugin outside of a run: Ctrl-C raises `CtrlC` in it.

    Afterwards the working folder, standard output and error, and the handlers of SIGINT, SIGTERM and SIGHUP are what
    they were, and a copy of the process that a fork made ends. During it a handler of SIGINT that is not Python's own
    stays, and so does everything outside the main thread, where Python delivers no signals.
    """
    process = os.getpid()
    is_main = threading.current_thread() is threading.main_thread()
    handlers = {number: signal.getsignal(number) for number in _SIGNALS} if is_main else {}
    streams = sys.stdout, sys.stderr
    if handlers.get(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, raise_ctrl_c)
    try:
        with working_folder_restored():
            yield
    finally:
        if os.getpid() != process:
            os._exit(1)
        sys.stdout, sys.stderr = streams
        for number, handler in handlers.items():
            if handler is not None:  # installed by other code than Python's
                signal.signal(number, handler)


@contextmanager
def working_folder_restored() -> Iterator[None]:
    """Restore the working folder afterwards, so that relative paths mean what the user wrote."""
    try:
        folder = os.getcwd()
    except OSError:  # it was removed
        yield
        return
    try:
        yield
    finally:
        with suppress(OSError):
            if not _is_working_folder(folder):
                os.chdir(folder)


def _is_working_folder(folder: str) -> bool:
    try:
        return os.getcwd() == folder
    except OSError:
        return False
