"""Whether the terminal shows colours."""

from __future__ import annotations

import curses
import os
import sys

_MIN_COLOURS = 8


def has_colours() -> bool:
    """Whether the terminal's description names colours; an unknown terminal counts as one that has them."""
    if os.environ.get("COLORTERM") or sys.__stdout__ is None:
        return True
    try:
        curses.setupterm(fd=sys.__stdout__.fileno())
    except curses.error:
        return True
    return curses.tigetnum("colors") >= _MIN_COLOURS
