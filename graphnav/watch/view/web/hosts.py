"""Check the Host and Origin headers, so that pages of other sites cannot reach this server."""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Sequence

_LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[0-9a-z._-]+)(?::([0-9]{1,5}))?")
_HTTP = 80


class Hosts:
    """The host names accepted in requests.

    On the loopback interface only its own names: other DNS names that resolve to it (DNS rebinding) are rejected. On
    all interfaces any IP address, which DNS cannot forge, and the machine's host name.
    """

    def __init__(self, host: str, port: int) -> None:
        self._port = port
        self._names = {*_LOOPBACK, bracketed(host.lower())}
        self._is_everywhere = (address := _address(host)) is not None and address.is_unspecified
        if self._is_everywhere:
            self._names.add(socket.gethostname().lower())

    def admits(self, hosts: Sequence[str]) -> bool:
        """Whether a request has exactly one Host header, which names this server."""
        found = _HOST.fullmatch(hosts[0].lower()) if len(hosts) == 1 else None
        if found is None or int(found[2] or _HTTP) != self._port:
            return False
        return found[1] in self._names or (self._is_everywhere and _address(found[1].strip("[]")) is not None)

    def admits_origin(self, origins: Sequence[str], host: str) -> bool:
        """Whether a request comes from the page served under the name ``host``."""
        return len(origins) == 1 and origins[0].lower() == f"http://{host.lower()}"


def is_loopback(host: str) -> bool:
    """Whether only programs of this machine can reach an address."""
    address = _address(host)
    return host.lower() == "localhost" if address is None else address.is_loopback


def url_of(host: str, port: int) -> str:
    """Return the URL of the page for a browser on this machine."""
    address = _address(host)
    shown = "127.0.0.1" if address is not None and address.is_unspecified else bracketed(host)
    return f"http://{shown}:{port}/"


def bracketed(host: str) -> str:
    """Return an address in URL notation."""
    return f"[{host}]" if ":" in host else host


def _address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None
