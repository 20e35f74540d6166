"""Query the terminal for its graphics protocols."""

from __future__ import annotations

import os
import re
import select
import struct
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

if sys.platform != "win32":
    import fcntl
    import termios
    import tty

_QUERY_ATTRIBUTES = b"\x1b[c"
_QUERY_KITTY = b"\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\"
_QUERY_COLOURS = b"\x1b[?1;1;0S"
_QUERY_CELL_SIZE = b"\x1b[16t"
_ATTRIBUTES = re.compile(rb"\x1b\[\?([\d;]*)c")
_KITTY_OK = re.compile(rb"\x1b_Gi=31;OK\x1b\\")
_COLOURS = re.compile(rb"\x1b\[\?1;0;(\d{1,5})S")
_CELL = re.compile(rb"\x1b\[6;(\d{1,3});(\d{1,3})t")
_SIXEL = b"4"
_TIMEOUT_S = 0.5
_MAX_BYTES = 4096
_ECHOES_UNKNOWN_QUERIES = {"linux", "dumb", ""}
_MULTIPLEXERS = {"TMUX": "tmux", "STY": "screen"}


@dataclass(frozen=True)
class TerminalGraphics:
    """The graphics protocols that a terminal confirms: kitty and sixel.

    ``n_colours``: colour registers for sixels. ``cell_px``: rows and columns of pixels of a cell, None if unknown.
    ``failure``: why nothing better than half blocks is available, empty if the terminal answered.
    """

    kitty: bool = False
    sixel: bool = False
    n_colours: int = 256
    cell_px: tuple[int, int] | None = None
    failure: str = ""

    @staticmethod
    def query() -> TerminalGraphics | None:
        """Query the terminal; None unless standard input and output are a terminal with this program in the foreground.

        Takes half a second if the terminal does not answer. Keys typed in the meantime are lost. tmux and screen are
        not queried: what they pass through depends on their version and on every attached terminal.
        """
        stdin, stdout = sys.__stdin__, sys.__stdout__
        if stdin is None or stdout is None or not (_is_foreground_terminal(stdin) and _is_foreground_terminal(stdout)):
            return None
        if os.environ.get("TERM", "") in _ECHOES_UNKNOWN_QUERIES:
            return TerminalGraphics()
        for variable, name in _MULTIPLEXERS.items():
            if os.environ.get(variable):
                return TerminalGraphics(failure=f"not queried inside {name}")
        try:
            return _query(stdin.fileno(), stdout.fileno())
        except (OSError, termios.error) as error:
            return TerminalGraphics(failure=f"the terminal cannot be queried: {error}")

    @staticmethod
    def cell_size_px() -> tuple[int, int] | None:
        """Return the rows and columns of pixels of a cell, None if the kernel does not know them."""
        if sys.platform == "win32":
            return None
        try:
            answer = fcntl.ioctl(sys.__stdout__, termios.TIOCGWINSZ, bytes(8))  # type: ignore[arg-type]
        except (OSError, TypeError, ValueError):
            return None
        rows, cols, width_px, height_px = struct.unpack("HHHH", answer)
        is_known = rows and cols and height_px >= rows and width_px >= cols
        return (height_px // rows, width_px // cols) if is_known else None


def _is_foreground_terminal(stream: object) -> bool:
    """Whether a stream is a terminal with this program in the foreground: background programs would be stopped."""
    try:
        fd = stream.fileno()  # type: ignore[attr-defined]
        return os.isatty(fd) and os.tcgetpgrp(fd) == os.getpgrp()
    except (AttributeError, OSError, ValueError):
        return False


def _query(stdin: int, stdout: int) -> TerminalGraphics:
    """Return the confirmed protocols; all terminals answer the last query, which ends the wait."""
    with _unechoed(stdin):
        os.write(stdout, _QUERY_ATTRIBUTES)
        attributes = _ATTRIBUTES.search(_answer(stdin))
        if attributes is None:
            return TerminalGraphics()
        os.write(stdout, _QUERY_KITTY + _QUERY_COLOURS + _QUERY_CELL_SIZE + _QUERY_ATTRIBUTES)
        answer = _answer(stdin)
    colours, cell = _COLOURS.search(answer), _CELL.search(answer)
    cell_px = (int(cell[1]), int(cell[2])) if cell else (0, 0)
    return TerminalGraphics(
        kitty=_KITTY_OK.search(answer) is not None,
        sixel=_SIXEL in attributes[1].split(b";")[1:],
        n_colours=max(2, int(colours[1])) if colours else 256,
        cell_px=cell_px if all(cell_px) else None,
    )


def _answer(stdin: int) -> bytes:
    """Return the terminal's answers up to its attributes, or within half a second."""
    answer = b""
    end_s = time.monotonic() + _TIMEOUT_S
    while (left_s := end_s - time.monotonic()) > 0 and len(answer) < _MAX_BYTES and not _ATTRIBUTES.search(answer):
        if select.select([stdin], [], [], left_s)[0]:
            answer += os.read(stdin, 256)
    return answer


@contextmanager
def _unechoed(fd: int) -> Iterator[None]:
    """Set a terminal to unbuffered input without echo; restore it afterwards."""
    before = termios.tcgetattr(fd)
    try:
        tty.setcbreak(fd, termios.TCSANOW)
        yield
    finally:
        termios.tcflush(fd, termios.TCIFLUSH)
        termios.tcsetattr(fd, termios.TCSANOW, before)
