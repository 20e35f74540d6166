"""What pictures the terminal can show."""

from __future__ import annotations

from graphnav.doctor.finding import Finding
from graphnav.machine.terminal_graphics import ask_terminal

_SUBJECT = "terminal graphics"


def terminal_graphics() -> Finding:
    """Ask the terminal, where this program is run from one."""
    graphics = ask_terminal()
    if graphics is None:
        return Finding(_SUBJECT, fine=True, seen="not asked: this is not run from a terminal")
    confirmed = [name for name, is_so in (("kitty", graphics.kitty), ("sixel", graphics.sixel)) if is_so]
    seen = ", ".join([*confirmed, "half blocks"])
    return Finding(_SUBJECT, fine=True, seen=f"{seen}; {graphics.failure}" if graphics.failure else seen)
