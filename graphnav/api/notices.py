"""Log notices with the logger ``graphnav``, which prints to stderr by default."""

from __future__ import annotations

import logging


def tell(notice: str) -> None:
    """Log a notice as a warning."""
    logging.getLogger("graphnav").warning("%s", notice)
