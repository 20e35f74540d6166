"""What a page watches: the messages of a feed, gathered by a thread that no browser can hold up."""

from __future__ import annotations

import threading
from typing import Protocol

from graphnav.view.watch import Watch


class Source(Protocol):
    """A feed that is being watched; whoever looks at ``watch`` holds ``lock``.

    ``watch`` is another object after a jump in a log. ``failure`` says what ended it, empty while it goes on.
    """

    lock: threading.Lock
    watch: Watch
    name: str
    failure: str

    def dropped_packets(self) -> int:
        """Return how many packets the kernel dropped before they could be received; 0 in a log."""

    def start(self) -> None:
        """Begin to gather."""

    def close(self) -> None:
        """Stop; return when the thread has ended."""
