"""Count the packets that the kernel dropped at sockets of this process, and read how large their buffers are."""

from __future__ import annotations

import os
import socket
from contextlib import suppress
from pathlib import Path

from graphnav.core.machine.receive_buffer import KERNEL_DOUBLES

_UDP = Path("/proc/net/udp")
_OWN_FILES = Path("/proc/self/fd")
_SOCKET = "socket:["
_INODE, _DROPS = 9, 12
"""Columns of /proc/net/udp."""


def own_sockets() -> frozenset[str]:
    """Return the inodes of this process's open sockets."""
    return frozenset(_own_sockets())


def _own_sockets() -> dict[str, int]:
    """Return the descriptors of this process's open sockets by their inodes."""
    links = {}
    for file in _OWN_FILES.iterdir():
        with suppress(OSError):  # closed in the meantime
            links[os.readlink(file)] = int(file.name)
    return {link[len(_SOCKET) : -1]: fd for link, fd in links.items() if link.startswith(_SOCKET)}


def dropped_packets(sockets: frozenset[str]) -> int:
    """Return how many packets the kernel dropped at UDP sockets because their buffers were full."""
    try:
        rows = [line.split() for line in _UDP.read_text().splitlines()[1:]]
    except OSError:
        return 0
    return sum(int(row[_DROPS]) for row in rows if len(row) > _DROPS and row[_INODE] in sockets)


def receive_buffer_bytes(sockets: frozenset[str]) -> int:
    """Return the smallest receive buffer of the UDP sockets, as requested of the kernel; 0 without such sockets."""
    sizes = []
    for inode, fd in _own_sockets().items():
        if inode in sockets:
            with suppress(OSError), socket.socket(fileno=os.dup(fd)) as found:
                if (found.family, found.type) == (socket.AF_INET, socket.SOCK_DGRAM):
                    sizes.append(found.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) // KERNEL_DOUBLES)
    return min(sizes, default=0)
