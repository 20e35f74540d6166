"""Receive buffers of UDP sockets: how large they are, what they hold, and the packets that the kernel dropped."""

from __future__ import annotations

import os
import socket
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple

from graphnav.core.large_messages.child import FRAGMENT_BYTES

KERNEL_DOUBLES = 2
"""Linux grants twice the requested size, for its own bookkeeping."""
_EVERYTHING = 2**30
_PACKET_COST_BYTES = 70_000
"""The share of the requested buffer that a full packet takes: 66,700 on Linux before 6.x, half of it since."""
_MAX_PACKETS = 256
_UDP = Path("/proc/net/udp")
_OWN_FILES = Path("/proc/self/fd")
_SOCKET = "socket:["
_INODE, _DROPS = 9, 12
"""Columns of /proc/net/udp."""


@dataclass(frozen=True)
class ReceiveBuffer:
    """A receive buffer: the size granted by the kernel, and the number of full packets that fit."""

    REQUESTED_BYTES: ClassVar[int] = 2_097_152
    """The buffer that graphnav asks for, sized for messages of many packets; the kernel may grant less."""
    granted_bytes: int
    packets: int

    @property
    def held_bytes(self) -> int:
        """The largest message that is received completely while the receiver is busy."""
        return self.packets * FRAGMENT_BYTES

    @staticmethod
    def measured(asked_bytes: int) -> ReceiveBuffer:
        """Fill a socket's buffer on this machine with packets of the size that LCM sends; raises OSError.

        ``asked_bytes``: the requested size, 0 for the kernel's default.
        """
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
            if asked_bytes:
                receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, asked_bytes)
            receiver.bind(("127.0.0.1", 0))
            receiver.settimeout(0)
            granted = receiver.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
            with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
                packet = bytes(FRAGMENT_BYTES)
                for _ in range(_MAX_PACKETS):
                    sender.sendto(packet, receiver.getsockname())
            packets = 0
            try:
                while receiver.recv(FRAGMENT_BYTES + 1):
                    packets += 1
            except BlockingIOError:
                pass
        return ReceiveBuffer(granted, packets)

    @staticmethod
    def limit() -> int:
        """Return the largest buffer that the kernel grants, ``net.core.rmem_max``: containers may hide the setting."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _EVERYTHING)
            return probe.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) // KERNEL_DOUBLES

    @staticmethod
    def needed(message_bytes: int) -> int:
        """Return the size to request for messages that arrive in one burst."""
        return max(ReceiveBuffer.REQUESTED_BYTES, -(-message_bytes // FRAGMENT_BYTES) * _PACKET_COST_BYTES)

    @staticmethod
    def larger(asked_bytes: int, needed_bytes: int) -> LargerBuffer:
        """Return what a receiver whose URL requests ``asked_bytes`` lacks to get ``needed_bytes``."""
        return LargerBuffer(
            f"sysctl -w net.core.rmem_max={needed_bytes}" if ReceiveBuffer.limit() < needed_bytes else "",
            f"recv_buf_size={needed_bytes}" if asked_bytes < needed_bytes else "",
        )


class LargerBuffer(NamedTuple):
    """Steps that give a receiver a larger buffer, each empty if it is not needed."""

    command: str
    """For root."""
    url_option: str

    def __str__(self) -> str:
        return "; ".join(filter(None, (self.command, self.url_option and f"{self.url_option} in its URL")))


def own_sockets() -> frozenset[str]:
    """Return the inodes of this process's open sockets."""
    return frozenset(_descriptors())


def _descriptors() -> dict[str, int]:
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
    for inode, fd in _descriptors().items():
        if inode in sockets:
            with suppress(OSError), socket.socket(fileno=os.dup(fd)) as found:
                if (found.family, found.type) == (socket.AF_INET, socket.SOCK_DGRAM):
                    sizes.append(found.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) // KERNEL_DOUBLES)
    return min(sizes, default=0)
