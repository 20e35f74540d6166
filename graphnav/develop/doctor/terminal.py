"""Check the graphics protocols of the terminal."""

from __future__ import annotations

from graphnav.core.machine import TerminalGraphics
from graphnav.develop.doctor.finding import Finding

_SUBJECT = "terminal graphics"


def terminal_graphics() -> Finding:
    """Query the terminal, if this program runs in one."""
    graphics = TerminalGraphics.query()
    if graphics is None:
        return Finding(_SUBJECT, fine=True, seen="not checked: not a terminal")
    confirmed = [name for name, is_so in (("kitty", graphics.kitty), ("sixel", graphics.sixel)) if is_so]
    seen = ", ".join([*confirmed, "half blocks"])
    return Finding(_SUBJECT, fine=True, seen=f"{seen}; {graphics.failure}" if graphics.failure else seen)
