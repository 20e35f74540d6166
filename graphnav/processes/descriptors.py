"""Look at a descriptor: whether there is something to read."""

from __future__ import annotations

import select


def is_readable(fd: int, within_s: float = 0.0) -> bool:
    """Wait until there is something to read, or the other end is gone; return whether that is so."""
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    return bool(poll.poll(within_s * 1e3))
