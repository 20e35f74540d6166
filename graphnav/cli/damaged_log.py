"""Report damage of a log before the error of a command that fails on it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from graphnav.errors import GraphnavError
from graphnav.notices import print_notice

if TYPE_CHECKING:
    from graphnav.record import Recording


@contextmanager
def damage_told(recording: Recording) -> Iterator[None]:
    """Report the damage of a log before the error that ends the command: it may be the cause."""
    try:
        yield
    except GraphnavError:
        if notice := recording.damage_notice():
            print_notice(notice)
        raise
