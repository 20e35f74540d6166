"""Raise `CtrlC` where it is not lost: not while a module is imported, and not in a callback without a caller."""

from __future__ import annotations

import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

from graphnav.core.interrupts.user_ends import CtrlC

_AGAIN_S = 0.02
_PATIENCE_S = 5.0
_IMPORTS = "<frozen importlib"
_waits_until_s = 0.0
_raised_for: int = signal.SIGINT


def raise_ctrl_c(number: int = signal.SIGINT, frame: FrameType | None = None) -> None:
    """Raise `CtrlC`; a signal handler.

    Within an import it is raised after that, at the latest after 5 s: compiled modules turn exceptions into an
    ImportError, or abort the process.
    """
    global _waits_until_s, _raised_for  # noqa: PLW0603, signals are of the process
    now_s = time.monotonic()
    if _is_importing(frame):
        if now_s > _waits_until_s + _PATIENCE_S:  # it is the first of them
            _waits_until_s = now_s + _PATIENCE_S
        if now_s < _waits_until_s:
            _send_again(number)
            return
    _raised_for = number
    raise CtrlC


@contextmanager
def ctrl_c_not_lost() -> Iterator[None]:
    """Send the signal again whose `CtrlC` had no caller, as that of a destructor, instead of printing a traceback."""
    usual = sys.unraisablehook

    def send_again(lost: sys.UnraisableHookArgs) -> None:
        if isinstance(lost.exc_value, CtrlC):
            _send_again(_raised_for)
        else:
            usual(lost)

    sys.unraisablehook = send_again
    try:
        yield
    finally:
        sys.unraisablehook = usual


@contextmanager
def ctrl_c_later() -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP wait for the end of the block, so that it makes its objects completely."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM, signal.SIGHUP))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def plain_ctrl_c() -> Iterator[None]:
    """Let SIGINT raise a KeyboardInterrupt in the block, which asyncio then turns into the end of its task."""
    if signal.getsignal(signal.SIGINT) is not raise_ctrl_c:
        yield
        return
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, raise_ctrl_c)


def _is_importing(frame: FrameType | None) -> bool:
    """Whether a frame is called by an import."""
    while frame is not None and not frame.f_code.co_filename.startswith(_IMPORTS):
        frame = frame.f_back
    return frame is not None


def _send_again(number: int) -> None:
    """Send the main thread a signal in a moment, which also interrupts what it waits for."""
    timer = threading.Timer(_AGAIN_S, signal.pthread_kill, [threading.main_thread().ident, number])
    timer.daemon = True
    timer.start()
