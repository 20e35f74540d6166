"""The process that sends large messages: LCM's wire format, with a gap after each packet.

Started by `graphnav.core.large_messages.sender` as a script that imports the standard library alone, to be ready
within 20 ms. Messages are in shared memory; orders to send them come from a socket, and each is answered in turn.

References
----------
.. [LCM] A. S. Huang, E. Olson, D. C. Moore, LCM: Lightweight Communications and Marshalling, IROS 2010;
   "UDP Multicast Protocol Description" of its documentation. Fragments are cut as liblcm 1.5 cuts them.
"""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
import select
import signal
import socket
import struct
import sys
import time
from collections import deque
from collections.abc import Iterator
from typing import NamedTuple

MEMORY_BYTES = 64 << 20
"""Size of the shared memory, which holds the messages that are being sent."""
MAX_ORDER_BYTES = 512
SENT, OVERTAKEN = 0, -1
"""Answers to an order; any other one is the error number of the network's refusal."""
ORDER = struct.Struct("=QQ?")
"""An order: offset and size in the shared memory, whether only the newest of its channel counts; then the channel."""
ANSWER = struct.Struct("=i")

PACKET_BYTES = 65_499
"""The maximum size of a channel name, its terminating zero and a message in one packet."""
FRAGMENT_BYTES = 65_487
"""The bytes of a message of several packets in one of them."""
GAP_S, SHORT_GAP_S = 1000e-6, 500e-6
"""The time between packets, and while other messages are pending: a receiver that is woken by each packet keeps up.

With 1 ms fewer are lost beside busy processes than with 0.5 ms, most of all by Java. Gigabit Ethernet takes 0.52 ms.
"""

NUMBERS = (0, 2**32)
"""The sequence numbers of packets: the first one, and how many there are before it comes again."""
FORWARDED = (int.from_bytes(b"tun\0", "big"), 256)
"""Those of messages that came from another host: what has them is not forwarded again. Of the numbers that other
programs count through, 0 to 2**32 - 1, these are so few that their messages are lost to tunnels alone, and rarely."""

_SHORT, _LONG = struct.Struct(">II"), struct.Struct(">IIIIHH")
_SHORT_MAGIC, _LONG_MAGIC = 0x4C433032, 0x4C433033


class Order(NamedTuple):
    """An order to send a message."""

    channel: bytes
    at: int
    n_bytes: int
    newest_only: bool


def packets(channel: bytes, data: memoryview, number: int) -> Iterator[list[bytes | memoryview]]:
    """Yield the packets of a message, each as a list of parts; ``number``: its sequence number."""
    if len(channel) + 1 + len(data) <= PACKET_BYTES:
        yield [_SHORT.pack(_SHORT_MAGIC, number), channel + b"\0", data]
        return
    count = -(-(len(channel) + 1 + len(data)) // FRAGMENT_BYTES)
    name, begin = channel + b"\0", 0
    for k in range(count):
        end = min(begin + FRAGMENT_BYTES - len(name), len(data))
        yield [_LONG.pack(_LONG_MAGIC, number, len(data), begin, k, count), name, data[begin:end]]
        name, begin = b"", end


class Child:
    """Sends what is ordered until ``orders`` closes and all is sent, or until the process ``parent`` ends.

    ``numbers``: as `NUMBERS`.
    """

    def __init__(
        self,
        orders: socket.socket,
        memory: mmap.mmap,
        network: socket.socket,
        group: tuple[str, int],
        parent: int,
        numbers: tuple[int, int],
    ) -> None:
        self._orders, self._memory, self._network, self._group = orders, memory, network, group
        self._pending: deque[Order] = deque()
        self._first_number, self._n_numbers = numbers
        self._count = 0
        self._due_s = 0.0
        self._is_open = True
        self._poll = select.poll()
        self._poll.register(orders, select.POLLIN)
        self._parent_fd = -1
        with contextlib.suppress(OSError):  # a kernel without pidfd
            self._parent_fd = os.pidfd_open(parent)
            self._poll.register(self._parent_fd, select.POLLIN)

    def run(self) -> None:
        """Send until there are no more orders."""
        while self._is_open or self._pending:
            if self._is_open and not self._take(wait=not self._pending):
                return
            if self._pending:
                order = self._pending.popleft()
                is_overtaken = order.newest_only and any(
                    later.newest_only and later.channel == order.channel for later in self._pending
                )
                self._answer(OVERTAKEN if is_overtaken else self._send(order))

    def _take(self, *, wait: bool) -> bool:
        """Read all orders, after waiting for one with ``wait``; return whether the program still runs."""
        ready = dict(self._poll.poll(None if wait else 0))
        while self._orders.fileno() in ready:
            data = self._orders.recv(MAX_ORDER_BYTES)
            if not data:
                self._is_open = False
                return True
            at, n_bytes, newest_only = ORDER.unpack_from(data)
            self._pending.append(Order(data[ORDER.size :], at, n_bytes, newest_only))
            ready = dict(self._poll.poll(0))
        return self._parent_fd not in ready

    def _send(self, order: Order) -> int:
        """Send a message; return the answer."""
        self._count += 1
        number = self._first_number + self._count % self._n_numbers
        gap_s = SHORT_GAP_S if self._pending else GAP_S
        with memoryview(self._memory) as memory, memory[order.at : order.at + order.n_bytes] as data:
            for parts in packets(order.channel, data, number):
                if (wait_s := self._due_s - time.monotonic()) > 0:
                    time.sleep(wait_s)
                try:
                    self._network.sendmsg(parts, (), 0, self._group)  # connected, it would keep a source address
                except OSError as error:
                    return error.errno or errno.EIO
                finally:
                    del parts  # it holds the memory
                self._due_s = time.monotonic() + gap_s
        return SENT

    def _answer(self, answer: int) -> None:
        with contextlib.suppress(OSError):  # the program has ended, or closed its side
            self._orders.send(ANSWER.pack(answer))


def main() -> None:
    """Send for the program that started this process."""
    orders_fd, memory_fd, parent, host, port, ttl, first_number, n_numbers = sys.argv[1:]
    for number in (signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])  # blocked signals are inherited from the parent thread
    network = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    network.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, int(ttl))
    memory = mmap.mmap(int(memory_fd), MEMORY_BYTES, prot=mmap.PROT_READ)
    numbers = int(first_number), int(n_numbers)
    Child(socket.socket(fileno=int(orders_fd)), memory, network, (host, int(port)), int(parent), numbers).run()


if __name__ == "__main__":
    main()
