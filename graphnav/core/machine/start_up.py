"""Ctrl-C, SIGTERM and SIGHUP while a command starts, where they end the process at once, and after that.

Nothing has to be saved or stopped at the start. An exception raised by the signal would not do: within an import it may
be printed and lost, or turned into the ImportError of a compiled module.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from graphnav.core.interrupts import raise_ctrl_c

_INTERRUPTED = 130
_STDERR = 2
_ENDING = (signal.SIGTERM, signal.SIGHUP)


def end_at_interrupt() -> None:
    """Let Ctrl-C, SIGTERM and SIGHUP end the process at once, unless they are ignored or handled otherwise."""
    if not _is_main_thread():
        return
    if signal.getsignal(signal.SIGINT) in {signal.default_int_handler, raise_ctrl_c}:
        signal.signal(signal.SIGINT, _end)
    for number in _ENDING:
        if signal.getsignal(number) is raise_ctrl_c:
            signal.signal(number, signal.SIG_DFL)


def raise_at_interrupt() -> None:
    """Let Ctrl-C, SIGTERM and SIGHUP raise `CtrlC` after `end_at_interrupt`."""
    if not _is_main_thread():
        return
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, raise_ctrl_c)
    for number in _ENDING:
        if signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, raise_ctrl_c)


@contextmanager
def ended_by_interrupt(*, owns_process: bool) -> Iterator[None]:
    """Let Ctrl-C, SIGTERM and SIGHUP end the process at once in the block, if the process is the command's own."""
    if not owns_process:
        yield
        return
    end_at_interrupt()
    try:
        yield
    finally:
        raise_at_interrupt()


def _is_main_thread() -> bool:
    """Whether this thread may handle signals: Python delivers them to no other one."""
    return threading.current_thread() is threading.main_thread()


def _end(*_: object) -> None:
    try:
        os.write(_STDERR, b"stopped\n")
    finally:
        os._exit(_INTERRUPTED)
