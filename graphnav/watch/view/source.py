"""The interface of sources: the messages of a feed, collected by a thread that browsers cannot block."""

from __future__ import annotations

import threading
from typing import Protocol

from graphnav.watch.view.watch import Watch


class Source(Protocol):
    """A watched feed; readers of ``watch`` must hold ``lock``.

    ``watch`` is replaced after a jump in a log. ``failure``: the error that ended the source, empty while it runs.
    """

    lock: threading.Lock
    watch: Watch
    name: str
    failure: str

    def dropped_packets(self) -> int:
        """Return the number of packets dropped by the kernel; 0 for a log."""

    def start(self) -> None:
        """Start the thread."""

    def close(self) -> None:
        """Stop; return when the thread has ended."""
