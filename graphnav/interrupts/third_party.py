"""Run code of plugins outside of a run."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from graphnav.interrupts.user_ends import raise_ctrl_c


@contextmanager
def third_party_code() -> Iterator[None]:
    """Run code of a plugin outside of a run: Ctrl-C raises `CtrlC` in it, and the working folder is restored after it.

    A handler of SIGINT that is not Python's own stays, and so does everything outside the main thread, where Python
    delivers no signals.
    """
    is_default = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if is_default:
        signal.signal(signal.SIGINT, raise_ctrl_c)
    try:
        with working_folder_restored():
            yield
    finally:
        if is_default:
            signal.signal(signal.SIGINT, signal.default_int_handler)


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
