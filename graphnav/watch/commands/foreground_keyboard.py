"""The keyboard of a command that also works without one: in a pipe, in the background, without a terminal."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from graphnav.core.keyboard import Terminal


class _NoKeyboard:
    """A keyboard without keys."""

    def read(self, timeout_s: float) -> bytes:
        """Wait."""
        time.sleep(max(0.0, timeout_s))
        return b""


@contextmanager
def open_keyboard() -> Iterator[tuple[Terminal | _NoKeyboard, bool]]:
    """Yield a keyboard and whether it has keys: only in the foreground of a terminal on both standard streams."""
    from graphnav.core.keyboard import Terminal

    if not _is_in_foreground():
        yield _NoKeyboard(), False
        return
    with Terminal(sys.stdin.fileno()) as terminal:
        yield terminal, True


def _is_in_foreground() -> bool:
    if sys.stdin is None or sys.stdout is None or not (sys.stdin.isatty() and sys.stdout.isatty()):
        return False
    if not hasattr(os, "tcgetpgrp"):  # Windows
        return False
    try:
        return os.tcgetpgrp(sys.stdin.fileno()) == os.getpgrp()
    except OSError:  # a terminal that does not control this process
        return False
