"""The process at the other end of a Unix socket."""

from __future__ import annotations

import socket
import struct

_CREDENTIALS = struct.Struct("=3i")


def peer_of(link: socket.socket) -> tuple[int, int]:
    """Return the process and the user at the other end, as the kernel noted them when it connected or listened."""
    data = link.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    pid, user, _ = _CREDENTIALS.unpack(data)
    return pid, user
