"""Measure how many bytes of a message the kernel buffers for a busy receiver."""

from __future__ import annotations

import socket
from typing import NamedTuple

from graphnav.bus import FRAGMENT_BYTES, RECEIVE_BUFFER_BYTES

_MAX_PACKETS = 256


class ReceiveBuffer(NamedTuple):
    """A receive buffer: the size granted by the kernel, and the number of full packets that fit."""

    granted_bytes: int
    packets: int

    @property
    def held_bytes(self) -> int:
        """The largest message that is received completely while the receiver is busy."""
        return self.packets * FRAGMENT_BYTES

    def needed_bytes(self, message_bytes: int) -> int:
        """Return the buffer size to request for a message, from the measured cost of a packet."""
        packets = -(-message_bytes // FRAGMENT_BYTES)
        cost = -(-self.granted_bytes // max(1, self.packets))
        return packets * cost // _KERNEL_DOUBLES


_KERNEL_DOUBLES = 2
"""Linux grants twice the requested size, for its own bookkeeping."""


def try_receive_buffer(asked_bytes: int = RECEIVE_BUFFER_BYTES) -> ReceiveBuffer:
    """Fill a socket's buffer on this machine with packets of the size that LCM sends; raises OSError."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
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
