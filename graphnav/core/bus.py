"""LCM: `memq://` inside a process, `udpm://` between processes."""

from __future__ import annotations

import ipaddress
import os
import re
import socket
from collections.abc import Callable, Mapping
from typing import Any
from urllib.parse import parse_qsl, urlencode, urlsplit

from graphnav.core.errors import BusError, NoRouteError
from graphnav.core.large_messages.child import FORWARDED, NUMBERS, PACKET_BYTES, packets
from graphnav.core.large_messages.sender import LargeSender
from graphnav.core.machine.packet_filter import filter_packets, ignore_forwarded
from graphnav.core.machine.receive_buffer import ReceiveBuffer, dropped_packets, own_sockets, receive_buffer_bytes
from graphnav.core.machine.system import require_linux
from graphnav.core.notices import print_notice

Handler = Callable[[str, bytes], None]

_HOST, _PORT = "239.255.76.67", 7667
_MAX_TTL = 255
_MAX_NAME_BYTES = 63
_SELF_TEST = "LCM_SELF_TEST"
_ALL = "(?s).*"
"""Also matches names with line breaks, unlike a plain dot."""
_DEFAULTS = {"ttl": "0", "recv_buf_size": str(ReceiveBuffer.REQUESTED_BYTES)}


class Bus:
    """One `lcm.LCM` object; a single thread owns it.

    On `memq://` messages reach the handlers of this object, in order, when `drain` is called, and are dropped without a
    subscriber. Queued messages are counted, which saves polling an empty queue. On `udpm://` they reach every process
    in the group, this one included.

    ``notice`` is told if the process that `send` uses for large messages fails. One that ``forwards`` messages of other
    hosts marks what it sends by sequence numbers that receivers ignore (`FORWARDED`), and does not hear what any
    program has marked: so nothing is forwarded twice, in whatever way the groups are joined.

    Raises BusError if LCM cannot be opened; without a multicast route the error names the command that adds one.
    """

    GROUP = f"udpm://{_HOST}:{_PORT}?ttl=0"
    """The multicast group where LCM's own tools listen by default; it does not leave the machine."""
    MAKE_ROUTE = "ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo"
    """The commands, run as root, that enable multicast on a machine without a network."""

    def __init__(
        self, url: str = "memq://", notice: Callable[[str], None] = print_notice, *, forwards: bool = False
    ) -> None:
        import lcm

        self.url = Bus.with_defaults(url)
        if self.url.startswith("udpm:"):
            Bus.require_route(self.url)
        try:
            self._lcm = lcm.LCM(self.url)
        except RuntimeError as error:
            raise BusError(f"LCM does not open {self.url}") from error
        self._subscriptions: list[Any] = []
        self._is_counted = self.url.startswith("memq:")
        self._channels: set[str] = set()
        self._receives_all = False
        self._waiting = 0
        self._sockets: frozenset[str] = frozenset()
        self._large = _large_sender(self.url, notice, forwards=forwards) if self.url.startswith("udpm:") else None
        self._forwarder = _Forwarder(self.url) if forwards else None

    def publish(self, channel: str, data: bytes) -> None:
        """Send a message by LCM, all its packets at once; raises BusError if the network refuses it."""
        try:
            if self._forwarder is not None:
                self._forwarder.publish(channel, data)
            else:
                self._lcm.publish(channel, data)
        except (OSError, RuntimeError, ValueError) as error:
            raise BusError(f"cannot publish {len(data)} bytes on '{channel}': {error}") from error
        if self._receives_all or channel in self._channels:
            self._waiting += 1

    def send(self, channel: str, data: bytes, *, newest_only: bool = False) -> None:
        """Send a message; the packets of a large one leave with gaps, so that small receive buffers hold them.

        Returns when it has left. With ``newest_only`` it returns at once, and a large message that is pending when a
        newer one of its channel comes is dropped and counted in `overtaken`. Messages of a channel stay in order.

        Raises BusError if the network refuses it, or with ``newest_only`` an earlier one.
        """
        large = self._large
        if large is None or (fits_packet(channel, data) and not large.is_sending(channel)):
            self.publish(channel, data)
            return
        if not large.send(channel, data, newest_only=newest_only):
            self.publish(channel, data)
        if large.refusal:
            error, large.refusal = OSError(large.refusal, os.strerror(large.refusal)), 0
            raise BusError(f"cannot publish {len(data)} bytes on '{channel}': {error}") from error

    def expect_large(self) -> None:
        """Start the process for large messages before the first one."""
        if self._large is not None:
            self._large.start()

    @property
    def overtaken(self) -> Mapping[str, int]:
        """The number of large messages of each channel that `send` dropped."""
        return self._large.overtaken if self._large is not None else {}

    def subscribe(self, channel: str, handler: Handler) -> None:
        """Call ``handler(channel, data)`` for each message of exactly this channel."""
        self._channels.add(channel)
        self._subscribe(re.escape(channel), handler)

    def subscribe_all(self, handler: Handler, max_waiting: int = 0) -> None:
        """Call ``handler(channel, data)`` for each message of every channel, except LCM's own tests of the network.

        ``max_waiting``: LCM drops further messages while this many are queued; 0 is unlimited.
        """

        def received(channel: str, data: bytes) -> None:
            if channel != _SELF_TEST:
                handler(channel, data)

        self._receives_all = True
        self._subscribe(_ALL, received, max_waiting)

    def drain(self) -> int:
        """Deliver until the queue is empty, including messages published by handlers; return the number of messages.

        Exceptions of handlers propagate; undelivered messages stay queued.
        """
        count = 0
        if self._is_counted:
            while self._waiting:
                self._waiting -= 1
                self._lcm.handle()
                count += 1
        else:
            while self._lcm.handle_timeout(0):
                count += 1
        return count

    def handle(self, timeout_s: float) -> bool:
        """Wait for one message and deliver it; return whether one arrived."""
        if self._is_counted:
            if self._waiting:
                self._waiting -= 1
                self._lcm.handle()
                return True
            return False
        return bool(self._lcm.handle_timeout(max(0, round(timeout_s * 1000))))

    def fileno(self) -> int:
        """Return a descriptor that is readable while messages wait, for a poll; only on `udpm://`."""
        return int(self._lcm.fileno())

    def dropped_packets(self) -> int:
        """Return the number of packets that the kernel dropped for lack of buffer space; 0 on `memq://`."""
        return dropped_packets(self._sockets)

    def receive_buffer_bytes(self) -> int:
        """Return the receive buffer that the kernel granted, as a URL requests it; 0 on `memq://` and unsubscribed."""
        return receive_buffer_bytes(self._sockets)

    def close(self) -> None:
        """Leave the network; the bus cannot be used afterwards."""
        for subscription in self._subscriptions:
            self._lcm.unsubscribe(subscription)  # otherwise LCM keeps references to the handlers
        self._subscriptions.clear()
        if self._large is not None:
            self._large.close()
        if self._forwarder is not None:
            self._forwarder.close()
        del self._lcm

    def _subscribe(self, pattern: str, handler: Handler, max_waiting: int = 0) -> None:
        others = frozenset[str]() if self._is_counted else own_sockets()
        subscription = self._lcm.subscribe(pattern, handler)
        if subscription is None:
            raise BusError(
                f"LCM cannot listen on {self.url}: its port is in use, or LCM's self test of the network failed",
                "choose another port, or run: graphnav doctor",
            )
        if not self._is_counted:
            self._sockets |= own_sockets() - others  # LCM opens its socket at the first subscription
        subscription.set_queue_capacity(max_waiting)
        if not self._subscriptions and self.url.startswith("udpm:"):
            port = urlsplit(self.url).port or _PORT
            if self._forwarder is None:
                filter_packets(port)
            else:
                ignore_forwarded(port, self._sockets)
        self._subscriptions.append(subscription)

    @staticmethod
    def with_defaults(url: str) -> str:
        """Return a URL whose defaults keep `udpm` traffic on this machine and request a large receive buffer.

        The default port is that of LCM. Raises BusError if it is not a URL.
        """
        try:
            parts = urlsplit(url)
            port = parts.port
        except ValueError as error:
            raise BusError(f"LCM does not open {url}: {error}") from error
        if parts.scheme != "udpm":
            return url
        options = _DEFAULTS | dict(parse_qsl(parts.query))
        group = parts.netloc or _HOST
        if port is None:
            group = f"{group.removesuffix(':')}:{_PORT}"
        return f"udpm://{group}?{urlencode(options)}"

    @staticmethod
    def requested_buffer(url: str) -> int:
        """Return the receive buffer that a URL requests; 0 for the kernel's default, which LCM takes for nonsense."""
        size = dict(parse_qsl(urlsplit(Bus.with_defaults(url)).query)).get("recv_buf_size", "")
        return int(size) if size.isdecimal() else 0

    @staticmethod
    def same_group(one: str, other: str) -> bool:
        """Whether two URLs have the same multicast group and port, regardless of their options."""
        return urlsplit(Bus.with_defaults(one))[:2] == urlsplit(Bus.with_defaults(other))[:2]

    @staticmethod
    def require_route(url: str) -> None:
        """Raise NoRouteError, with the command that fixes it, if no multicast route leads to the URL's group.

        Raises BusError if it has no multicast group, or port 0; UserError on another system than Linux, whose calls
        count what its sockets lose and filter what they receive.
        """
        require_linux("channels between programs work")
        parts = urlsplit(url)
        if not _is_multicast(parts.hostname or ""):
            raise BusError(
                f"'{parts.hostname}' is not a multicast address", f"write {Bus.GROUP}, or another group of 239.0.0.0/8"
            )
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                if parts.port == 0:
                    raise BusError(
                        f"port 0 of {parts.hostname} is not a port to listen on", f"write {Bus.GROUP}, or another port"
                    )
                probe.connect((parts.hostname or "", parts.port or _PORT))
            except OSError as error:
                raise NoRouteError(
                    f"no multicast route to {parts.hostname}", f"run as root: {Bus.MAKE_ROUTE}"
                ) from error
            except ValueError as error:
                raise BusError(f"LCM does not open {url}: {error}") from error


def fits_packet(channel: str, data: bytes) -> bool:
    """Whether LCM sends a message in one packet."""
    return len(channel.encode("utf-8", "surrogateescape")) + 1 + len(data) <= PACKET_BYTES


class _Forwarder:
    """Sends messages with the sequence numbers of forwarded ones, all packets of one at once."""

    def __init__(self, url: str) -> None:
        *group, ttl = _destination(url)
        self._group = tuple(group)
        self._count = 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, ttl)

    def publish(self, channel: str, data: bytes) -> None:
        """Send a message; raises ValueError for a name that LCM would not take, OSError if the network refuses it."""
        name = channel.encode("utf-8", "surrogateescape")
        if len(name) > _MAX_NAME_BYTES or b"\0" in name:
            raise ValueError("the channel name is too long, or has a null character")
        self._count += 1
        first, n_numbers = FORWARDED
        for parts in packets(name, memoryview(data), first + self._count % n_numbers):
            self._socket.sendmsg(parts, (), 0, self._group)

    def close(self) -> None:
        self._socket.close()


def _large_sender(url: str, notice: Callable[[str], None], *, forwards: bool) -> LargeSender:
    return LargeSender(*_destination(url), notice, FORWARDED if forwards else NUMBERS)


def _destination(url: str) -> tuple[str, int, int]:
    """Return address, port and time to live of what is sent to a URL with its defaults."""
    parts = urlsplit(url)
    ttl = dict(parse_qsl(parts.query))["ttl"]
    return parts.hostname or _HOST, parts.port or _PORT, min(int(ttl), _MAX_TTL) if ttl.isdecimal() else 0


def _is_multicast(host: str) -> bool:
    try:
        return ipaddress.IPv4Address(host).is_multicast
    except ValueError:
        return False
