"""Log notices with the logger ``graphnav``, which prints to stderr by default."""

from __future__ import annotations

import logging

from graphnav.core.errors import printable


def tell(notice: str) -> None:
    """Log a notice as a warning; it may quote what other programs sent."""
    logging.getLogger("graphnav").warning("%s", printable(notice))
