"""What pictures the terminal can show: it is asked, and says so itself."""

from __future__ import annotations

import fcntl
import os
import re
import select
import struct
import sys
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

_WHAT_ARE_YOU = b"\x1b[c"
_ARE_YOU_KITTY = b"\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\"
_HOW_MANY_COLOURS = b"\x1b[?1;1;0S"
_HOW_LARGE_A_CELL = b"\x1b[16t"
_ATTRIBUTES = re.compile(rb"\x1b\[\?([\d;]*)c")
_KITTY_OK = re.compile(rb"\x1b_Gi=31;OK\x1b\\")
_COLOURS = re.compile(rb"\x1b\[\?1;0;(\d{1,5})S")
_CELL = re.compile(rb"\x1b\[6;(\d{1,3});(\d{1,3})t")
_SIXEL = b"4"
_TIMEOUT_S = 0.5
_MAX_BYTES = 4096
_PRINTS_WHAT_IT_DOES_NOT_KNOW = {"linux", "dumb", ""}
_MULTIPLEXERS = {"TMUX": "tmux", "STY": "screen"}

CellSize = tuple[int, int]
"""Rows and columns of pixels of a cell."""


@dataclass(frozen=True)
class TerminalGraphics:
    """What a terminal confirms: the protocols of kitty and of sixels.

    ``n_colours``: registers for the colours of sixels. ``cell_px``: None if the terminal does not say it.
    ``failure``: why it does not show more than half blocks although it may, empty if it answered.
    """

    kitty: bool = False
    sixel: bool = False
    n_colours: int = 256
    cell_px: CellSize | None = None
    failure: str = ""


def ask_terminal() -> TerminalGraphics | None:
    """Ask the terminal; None if standard input and output are not a terminal that this program has for itself.

    Takes half a second where the terminal does not answer. What is typed meanwhile is lost. Inside tmux and screen
    nothing is asked: what they pass on depends on their version and on every terminal that is attached.
    """
    stdin, stdout = sys.__stdin__, sys.__stdout__
    if stdin is None or stdout is None or not (_is_ours(stdin) and _is_ours(stdout)):
        return None
    if os.environ.get("TERM", "") in _PRINTS_WHAT_IT_DOES_NOT_KNOW:
        return TerminalGraphics()
    for variable, name in _MULTIPLEXERS.items():
        if os.environ.get(variable):
            return TerminalGraphics(failure=f"inside {name}, which is not asked")
    try:
        return _ask(stdin.fileno(), stdout.fileno())
    except (OSError, termios.error) as error:
        return TerminalGraphics(failure=f"the terminal cannot be asked: {error}")


def cell_size_px() -> CellSize | None:
    """Return the rows and columns of pixels of a cell as the kernel knows them now; None if it does not."""
    try:
        answer = fcntl.ioctl(sys.__stdout__, termios.TIOCGWINSZ, bytes(8))  # type: ignore[arg-type]
    except (OSError, TypeError, ValueError):
        return None
    rows, cols, width_px, height_px = struct.unpack("HHHH", answer)
    return (height_px // rows, width_px // cols) if rows and cols and height_px >= rows and width_px >= cols else None


def _is_ours(stream: object) -> bool:
    """Whether a stream is a terminal of which this program is in the foreground: others are stopped if they ask."""
    try:
        fd = stream.fileno()  # type: ignore[attr-defined]
        return os.isatty(fd) and os.tcgetpgrp(fd) == os.getpgrp()
    except (AttributeError, OSError, ValueError):
        return False


def _ask(stdin: int, stdout: int) -> TerminalGraphics:
    """Return what the terminal confirms; all terminals answer the last question, which ends the wait."""
    with _unseen(stdin):
        os.write(stdout, _WHAT_ARE_YOU)
        attributes = _ATTRIBUTES.search(_answer(stdin))
        if attributes is None:
            return TerminalGraphics()
        os.write(stdout, _ARE_YOU_KITTY + _HOW_MANY_COLOURS + _HOW_LARGE_A_CELL + _WHAT_ARE_YOU)
        said = _answer(stdin)
    colours, cell = _COLOURS.search(said), _CELL.search(said)
    cell_px = (int(cell[1]), int(cell[2])) if cell else (0, 0)
    return TerminalGraphics(
        kitty=_KITTY_OK.search(said) is not None,
        sixel=_SIXEL in attributes[1].split(b";")[1:],
        n_colours=max(2, int(colours[1])) if colours else 256,
        cell_px=cell_px if all(cell_px) else None,
    )


def _answer(stdin: int) -> bytes:
    """Return what the terminal says up to its attributes, or within half a second."""
    said = b""
    end_s = time.monotonic() + _TIMEOUT_S
    while (left_s := end_s - time.monotonic()) > 0 and len(said) < _MAX_BYTES and not _ATTRIBUTES.search(said):
        if select.select([stdin], [], [], left_s)[0]:
            said += os.read(stdin, 256)
    return said


@contextmanager
def _unseen(fd: int) -> Iterator[None]:
    """Let a terminal give its answers at once and without an echo; then leave it as it was found."""
    before = termios.tcgetattr(fd)
    try:
        tty.setcbreak(fd, termios.TCSANOW)
        yield
    finally:
        termios.tcflush(fd, termios.TCIFLUSH)
        termios.tcsetattr(fd, termios.TCSANOW, before)
