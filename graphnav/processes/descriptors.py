"""Look at descriptors: the process at the other end of a socket, and whether there is something to read."""

from __future__ import annotations

import select
import socket
import struct

_CREDENTIALS = struct.Struct("=3i")


def is_readable(fd: int, within_s: float = 0.0) -> bool:
    """Wait until there is something to read, or the other end is gone; return whether that is so."""
    poll = select.poll()
    poll.register(fd, select.POLLIN)
    return bool(poll.poll(within_s * 1e3))


def peer_of(link: socket.socket) -> tuple[int, int]:
    """Return the process and the user at the other end, as the kernel noted them when it connected or listened."""
    data = link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, user, _ = _CREDENTIALS.unpack(data)
    return pid, user
