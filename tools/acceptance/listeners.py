"""Programs that listen on a UDP port of this machine, as the kernel tells them."""

from __future__ import annotations

import time
from pathlib import Path

_UDP = Path("/proc/net/udp")
_ADDRESS, _DROPS = 1, 12
"""Columns of /proc/net/udp."""


def count_listeners(port: int) -> int:
    """Return how many sockets are bound to a port."""
    return len(_drops(port))


def await_listeners(port: int, count: int, for_s: float) -> None:
    """Wait until so many sockets are bound to a port; raise TimeoutError if they are not in time."""
    end_s = time.monotonic() + for_s
    while count_listeners(port) < count:
        if time.monotonic() > end_s:
            raise TimeoutError(f"{count_listeners(port)} of {count} programs listen on port {port} after {for_s:g} s")
        time.sleep(0.1)


def _drops(port: int) -> list[int]:
    rows = [line.split() for line in _UDP.read_text(encoding="ascii").splitlines()[1:]]
    return [int(row[_DROPS]) for row in rows if int(row[_ADDRESS].rpartition(":")[2], 16) == port]
