"""Requests to a web server that no browser would send."""

from __future__ import annotations

import random
import socket
import urllib.error
import urllib.request
from contextlib import suppress
from urllib.parse import urlsplit

_PATHS = ("/", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/" + "a" * 70_000, "/\x1b[2J", "/%00", "//x", "*")
_WAIT_S = 2.0
_UPGRADE = (
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZQ==\r\nSec-WebSocket-Version: 13\r\n"
)


def hostile_request(url: str, drawn: random.Random) -> None:
    """Send one request, and leave before or after the answer."""
    parts = urlsplit(url)
    host = parts.netloc if drawn.random() < 0.7 else "evil.example"
    line = (
        f"{drawn.choice(('GET', 'POST', 'HEAD', 'X' * 9000))} {drawn.choice((*_PATHS, '/ws', '/events'))} HTTP/1.1\r\n"
    )
    ways: tuple[bytes, ...] = (
        drawn.randbytes(drawn.randrange(1, 3000)),
        f"{line}Host: {host}\r\n\r\n".encode(),
        f"{line}Host: {host}\r\nContent-Length: {drawn.choice((-1, 10**12, 'x'))}\r\n\r\n".encode(),
        f"GET /ws HTTP/1.1\r\nHost: {host}\r\n{_UPGRADE}\r\n".encode() + drawn.randbytes(300),
        f"{line}Host: {host}\r\n".encode() + b"X-Header: y\r\n" * 3000,
    )
    with suppress(OSError), socket.create_connection((parts.hostname, parts.port), timeout=_WAIT_S) as connection:
        connection.settimeout(_WAIT_S / 10)
        connection.sendall(drawn.choice(ways))
        if drawn.random() < 0.5:
            connection.recv(4096)


def answers(url: str) -> bool:
    """Whether a server still answers a request that is as it should be."""
    try:
        with urllib.request.urlopen(url, timeout=5 * _WAIT_S) as answer:  # noqa: S310 - http of this machine
            return bool(answer.status == 200)
    except (urllib.error.URLError, OSError):
        return False
