"""Count the packets that the kernel dropped at sockets of this process because their buffers were full."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

_UDP = Path("/proc/net/udp")
_OWN_FILES = Path("/proc/self/fd")
_SOCKET = "socket:["
_INODE, _DROPS = 9, 12
"""Columns of /proc/net/udp."""


def own_sockets() -> frozenset[str]:
    """Return the inodes of this process's open sockets."""
    links = []
    for file in _OWN_FILES.iterdir():
        with suppress(OSError):  # closed in the meantime
            links.append(os.readlink(file))
    return frozenset(link[len(_SOCKET) : -1] for link in links if link.startswith(_SOCKET))


def dropped_packets(sockets: frozenset[str]) -> int:
    """Return how many packets the kernel dropped at UDP sockets because their buffers were full."""
    try:
        rows = [line.split() for line in _UDP.read_text().splitlines()[1:]]
    except OSError:
        return 0
    return sum(int(row[_DROPS]) for row in rows if len(row) > _DROPS and row[_INODE] in sockets)
