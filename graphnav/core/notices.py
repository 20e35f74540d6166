"""Notices: warnings of a program that continues."""

from __future__ import annotations

import sys

from graphnav.core.errors import printable


def print_notice(notice: str) -> None:
    """Print a notice to standard error, unbuffered; it may quote what other programs sent."""
    print(printable(notice), file=sys.stderr, flush=True)
