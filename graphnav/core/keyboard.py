"""Single keys from a terminal: its mode, and its bytes as keys."""

from __future__ import annotations

import os
import re
import select
import sys
from contextlib import suppress
from types import TracebackType
from typing import Any, Self

if sys.platform != "win32":
    import termios

_ARROWS = {"A": "up", "B": "down", "C": "right", "D": "left"}
_SEQUENCE = re.compile(r"\x1b(?:O(?P<application>.)|\[(?P<arguments>[0-?]*[ -/]*)(?P<normal>[@-~]))", re.DOTALL)
_BEGUN = re.compile(r"\x1b(?:O|\[[0-?]*[ -/]*)?")
_MAX_BEGUN = 32
_LFLAG, _IFLAG, _CC = 3, 0, 6
_CHUNK = 4096
"""Maximum size of a terminal's input buffer."""


class KeyDecoder:
    """Decodes bytes into keys: lower-case characters, and ``up``, ``down``, ``left``, ``right``.

    The escape sequence of an arrow may arrive in pieces. Other sequences are ignored.
    """

    def __init__(self) -> None:
        self._begun = ""

    def feed(self, data: bytes) -> list[str]:
        """Return the keys that ``data`` completes."""
        text, self._begun = self._begun + data.decode("latin-1"), ""
        keys = []
        at = 0
        while at < len(text):
            if sequence := _SEQUENCE.match(text, at):
                arrow = _ARROWS.get(sequence["application"] or sequence["normal"])
                if arrow and not sequence["arguments"]:
                    keys.append(arrow)
                at = sequence.end()
            elif _BEGUN.fullmatch(text, at) and len(text) - at < _MAX_BEGUN:
                self._begun = text[at:]
                break
            else:
                keys.append(text[at].lower())
                at += 1
        return keys


class Terminal:
    """A context in which keys arrive one by one, without echo; Ctrl-Z, Ctrl-S and the key of SIGQUIT do nothing.

    Ctrl-C still raises KeyboardInterrupt. The terminal is restored however a command ends, except by SIGKILL. Not on
    Windows, whose console has no such modes.
    """

    def __init__(self, fd: int) -> None:
        self._fd = fd
        self._found: list[Any] = []

    def __enter__(self) -> Self:
        self._found = termios.tcgetattr(self._fd)
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

    def read(self, timeout_s: float) -> bytes | None:
        """Return the bytes typed, empty after the timeout, None once the terminal is closed."""
        if not select.select([self._fd], [], [], max(0.0, timeout_s))[0]:
            return b""
        try:
            return os.read(self._fd, _CHUNK) or None
        except OSError:
            return None
