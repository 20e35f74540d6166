"""Notices: warnings of a program that continues."""

from __future__ import annotations

import sys


def print_notice(notice: str) -> None:
    """Print a notice to standard error, unbuffered."""
    print(notice, file=sys.stderr, flush=True)
