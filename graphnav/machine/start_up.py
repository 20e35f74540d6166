"""Ctrl-C while a command starts: the process ends at once, with the status of an interrupted one.

Nothing has to be saved or stopped then. An exception raised by the signal would not do: within an import it may be
printed and lost, or turned into the ImportError of a compiled module.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_INTERRUPTED = 130
_STDERR = 2


def end_at_interrupt() -> None:
    """Let Ctrl-C end the process at once, unless it is ignored or handled otherwise."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_at_interrupt() -> None:
    """Let Ctrl-C raise KeyboardInterrupt again, after `end_at_interrupt`."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@contextmanager
def ended_by_interrupt(*, owns_process: bool) -> Iterator[None]:
    """Let Ctrl-C end the process at once in the block, if the process is the command's own."""
    if not owns_process or threading.current_thread() is not threading.main_thread():
        yield
        return
    end_at_interrupt()
    try:
        yield
    finally:
        raise_at_interrupt()


def _end(*_: object) -> None:
    try:
        os.write(_STDERR, b"stopped\n")
    finally:
        os._exit(_INTERRUPTED)
