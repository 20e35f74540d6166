"""The kernel's receive buffer of a multicast group: what it grants, and what it has dropped."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

_RMEM_MAX = Path("/proc/sys/net/core/rmem_max")
_UDP = Path("/proc/net/udp")
_OWN_FILES = Path("/proc/self/fd")
_SOCKET = "socket:["
_INODE, _DROPS = 9, 12
"""Columns of /proc/net/udp."""


def buffer_notice(url: str) -> str:
    """Return what to tell where the kernel grants less than the URL asks for, else nothing."""
    wanted = parse_qs(urlsplit(url).query).get("recv_buf_size", ["0"])[-1]
    try:
        wanted_bytes, granted_bytes = int(wanted), int(_RMEM_MAX.read_text())
    except (OSError, ValueError):
        return ""
    if granted_bytes >= wanted_bytes:
        return ""
    return (
        f"the kernel grants {granted_bytes} bytes of receive buffer, {wanted_bytes} are asked for: large messages will "
        f"be lost\n  run as root: sysctl -w net.core.rmem_max={wanted_bytes}"
    )


def own_sockets() -> frozenset[str]:
    """Return the inodes of this process's open sockets."""
    links = []
    for file in _OWN_FILES.iterdir():
        with suppress(OSError):  # closed meanwhile
            links.append(os.readlink(file))
    return frozenset(link[len(_SOCKET) : -1] for link in links if link.startswith(_SOCKET))


def dropped_packets(sockets: frozenset[str]) -> int:
    """Return how many packets the kernel dropped at UDP sockets, because they were not taken in time."""
    try:
        rows = [line.split() for line in _UDP.read_text().splitlines()[1:]]
    except OSError:
        return 0
    return sum(int(row[_DROPS]) for row in rows if len(row) > _DROPS and row[_INODE] in sockets)
