"""Notices: what a program tells while it goes on."""

from __future__ import annotations

import sys


def print_notice(notice: str) -> None:
    """Print a notice to standard error, at once."""
    print(notice, file=sys.stderr, flush=True)
