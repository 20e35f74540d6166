"""Shared by commands that read a feed: open its log, decide when to report and when to give up."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

from graphnav.core.parameters import Parameter, seconds

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence
    from pathlib import Path

    from graphnav.core.catalog import Catalog
    from graphnav.watch.feed import Feed, Watch

_EVERY_S = 1.0

TIMEOUT_S = Parameter(
    "timeout_s",
    "--timeout",
    type=seconds,
    metavar="S",
    help="end with status 1 if no message of the channel arrives for S seconds (default: wait)",
)
"""For `Timeout`."""


def complete(feed: Feed, catalog: Catalog, plugins: Sequence[Path], channels: Collection[str] | None = None) -> Feed:
    """Open the log of a feed, if it is one, with what it leaves out of ``channels``, None for all; return the feed."""
    from graphnav.core.cli import opened

    if not feed.is_live:
        feed.recording = opened(feed.path, catalog, plugins, channels)
    return feed


class Timeout:
    """Ends a command by an error if nothing arrives for as long as ``--timeout`` allows; a log is never waited for.

    ``name``: the channel, None for any.
    """

    def __init__(self, timeout_s: float | None, feed: Feed, watch: Watch, name: str | None) -> None:
        self._timeout_s = timeout_s if feed.is_live else None
        self._feed, self._watch, self._name = feed, watch, name
        self._since_s = time.monotonic()

    def note(self) -> None:
        """Note that a message has arrived."""
        self._since_s = time.monotonic()

    @property
    def waited_s(self) -> float:
        """Time since the last message, or since the start."""
        return time.monotonic() - self._since_s

    def check(self) -> None:
        """Raise GraphnavError if no message has arrived for too long."""
        if self._timeout_s is None or self.waited_s < self._timeout_s:
            return
        if self._name is None:
            raise self._feed.silence(self._timeout_s)
        raise self._watch.silence(self._name, self._feed, self._timeout_s)


class ReportTimes:
    """Once a second, but not in the half second before the final report. ``for_s``: None for no end."""

    def __init__(self, for_s: float | None) -> None:
        self._last_s = time.monotonic()
        self._end_s = None if for_s is None else self._last_s + for_s

    def is_due(self) -> bool:
        """Whether to print now; the next report is one second after it."""
        now_s = time.monotonic()
        if now_s - self._last_s < _EVERY_S or (self._end_s is not None and self._end_s - now_s < _EVERY_S / 2):
            return False
        self._last_s = now_s
        return True
