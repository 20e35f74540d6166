"""How much of a message the kernel holds for a program that is busy: tried, not computed."""

from __future__ import annotations

import socket
from typing import NamedTuple

from graphnav.bus import FRAGMENT_BYTES, RECEIVE_BUFFER_BYTES

_MAX_PACKETS = 256


class ReceiveBuffer(NamedTuple):
    """What a receiver gets that asks for LCM's buffer: as the kernel counts, and the full packets that fit."""

    granted_bytes: int
    packets: int

    @property
    def held_bytes(self) -> int:
        """The largest message of which no packet is lost while nothing is read."""
        return self.packets * FRAGMENT_BYTES

    def needed_bytes(self, message_bytes: int) -> int:
        """Return the buffer to ask for so that a message is held, from what a packet cost here."""
        packets = -(-message_bytes // FRAGMENT_BYTES)
        cost = -(-self.granted_bytes // max(1, self.packets))
        return packets * cost // _KERNEL_DOUBLES


_KERNEL_DOUBLES = 2
"""Linux grants twice what is asked for, to have room for its own bookkeeping."""


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
