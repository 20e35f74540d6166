"""Names and strings that came over the network, on one line and without what a terminal would obey."""

from __future__ import annotations

from graphnav.errors import printable


def printable_line(text: str) -> str:
    """Return a text whose control characters stand as escapes, line breaks too."""
    return printable(text).replace("\n", "\\n")
