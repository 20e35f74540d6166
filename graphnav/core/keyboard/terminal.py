"""Read a terminal key by key, and restore its settings afterwards."""

from __future__ import annotations

import os
import select
import signal
import termios
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any, NoReturn, Self

from graphnav.core.interrupts import Terminated

_LFLAG, _IFLAG, _CC = 3, 0, 6
_CHUNK = 4096
"""Maximum size of a terminal's input buffer."""


class Terminal:
    """A context in which keys arrive one by one, without echo; Ctrl-Z, Ctrl-S and the key of SIGQUIT do nothing.

    Ctrl-C still raises KeyboardInterrupt; SIGTERM and SIGHUP raise SystemExit, so that the terminal is restored
    however the program ends, except by SIGKILL.
    """

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._found: list[Any] = []
        self._handlers: dict[int, Any] = {}

    def __enter__(self) -> Self:
        self._found = termios.tcgetattr(self._fd)
        self._handlers = {number: signal.signal(number, _end) for number in (signal.SIGTERM, signal.SIGHUP)}
        single = termios.tcgetattr(self._fd)
        single[_LFLAG] &= ~(termios.ICANON | termios.ECHO)
        single[_IFLAG] &= ~termios.IXON
        off = bytes([os.fpathconf(self._fd, "PC_VDISABLE")])
        for place, value in (
            (termios.VMIN, 1),
            (termios.VTIME, 0),
            (termios.VSUSP, off),
            (termios.VQUIT, off),
        ):
            single[_CC][place] = value
        termios.tcsetattr(self._fd, termios.TCSANOW, single)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(termios.error):  # it may have been closed
            termios.tcflush(self._fd, termios.TCIFLUSH)  # pending keys are not meant for the shell
            termios.tcsetattr(self._fd, termios.TCSANOW, self._found)
        for number, handler in self._handlers.items():
            signal.signal(number, handler)

    def read(self, timeout_s: float) -> bytes | None:
        """Return the bytes typed, empty after the timeout, None once the terminal is closed."""
        if not select.select([self._fd], [], [], max(0.0, timeout_s))[0]:
            return b""
        try:
            return os.read(self._fd, _CHUNK) or None
        except OSError:
            return None


def _end(number: int, _frame: FrameType | None) -> NoReturn:
    raise Terminated(128 + number)
