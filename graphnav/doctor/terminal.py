"""What pictures the terminal can show: it is asked, and says so itself."""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from graphnav.doctor.finding import Finding

_SUBJECT = "terminal graphics"
_WHAT_ARE_YOU = b"\x1b[c"
_ARE_YOU_KITTY = b"\x1b_Gi=31,s=1,v=1,a=q,t=d,f=24;AAAA\x1b\\"
_ATTRIBUTES = re.compile(rb"\x1b\[\?([\d;]*)c")
_KITTY_OK = re.compile(rb"\x1b_Gi=31;OK\x1b\\")
_SIXEL = b"4"
_TIMEOUT_S = 0.5
_MAX_BYTES = 4096
_PRINTS_WHAT_IT_DOES_NOT_KNOW = {"linux", "dumb", ""}


def terminal_graphics() -> Finding:
    """Ask the terminal, where standard input and output are the same one and this program has it for itself."""
    if not (_is_ours(sys.__stdin__) and _is_ours(sys.__stdout__)):
        return Finding(_SUBJECT, fine=True, seen="not asked: this is not run from a terminal")
    if os.environ.get("TERM", "") in _PRINTS_WHAT_IT_DOES_NOT_KNOW:
        return Finding(_SUBJECT, fine=True, seen="half blocks")
    try:
        found = _ask(sys.__stdin__.fileno(), sys.__stdout__.fileno()) if sys.__stdin__ and sys.__stdout__ else []
    except (OSError, termios.error) as error:
        return Finding(_SUBJECT, fine=True, seen=f"half blocks; the terminal cannot be asked: {error}")
    return Finding(_SUBJECT, fine=True, seen=", ".join([*found, "half blocks"]))


def _is_ours(stream: object) -> bool:
    """Whether a stream is a terminal of which this program is in the foreground: others are stopped if they ask."""
    try:
        fd = stream.fileno()  # type: ignore[attr-defined]
        return os.isatty(fd) and os.tcgetpgrp(fd) == os.getpgrp()
    except (AttributeError, OSError, ValueError):
        return False


def _ask(stdin: int, stdout: int) -> list[str]:
    """Return the protocols that the terminal confirms; all terminals answer the last question, which ends the wait."""
    with _unseen(stdin):
        os.write(stdout, _WHAT_ARE_YOU)
        attributes = _ATTRIBUTES.search(_answer(stdin))
        if attributes is None:
            return []
        found = ["sixel"] if _SIXEL in attributes[1].split(b";")[1:] else []
        os.write(stdout, _ARE_YOU_KITTY + _WHAT_ARE_YOU)
        return ["kitty", *found] if _KITTY_OK.search(_answer(stdin)) else found


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
