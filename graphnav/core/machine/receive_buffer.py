"""The kernel's receive buffer: how large a message it holds while the receiver is busy, and what makes it larger."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from graphnav.core.large_messages.child import FRAGMENT_BYTES

KERNEL_DOUBLES = 2
"""Linux grants twice the requested size, for its own bookkeeping."""
_EVERYTHING = 2**30
_PACKET_COST_BYTES = 70_000
"""The share of the requested buffer that a full packet takes: 66,700 on Linux before 6.x, half of it since."""
_MAX_PACKETS = 256


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
