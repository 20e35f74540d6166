"""A relay of TCP connections that is as slow as it is told, and cuts them when it is told.

``python -m testbed.slow_link TARGET_PORT BYTES_PER_S`` prints the port on which it listens, and goes on until standard
input closes; each line of that cuts the connections that there are.
"""

from __future__ import annotations

import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

_CHUNK_BYTES = 16_384
_BUFFER_BYTES = 65_536
"""Small, so that what waits does so at the sender."""
_CUT = struct.pack("ii", 1, 0)
"""SO_LINGER: the other side learns it as of a connection that is broken."""


class SlowLink:
    """Carries each connection in two threads; ``bytes_per_s`` holds in either direction."""

    def __init__(self, target_port: int, bytes_per_s: float) -> None:
        self._target_port, self._bytes_per_s = target_port, bytes_per_s
        self._open: list[socket.socket] = []
        self._lock = threading.Lock()
        self._listening = socket.socket()
        self._listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)  # those that it accepts, too
        self._listening.bind(("127.0.0.1", 0))
        self._listening.listen()
        self.port: int = self._listening.getsockname()[1]

    def run(self) -> None:
        """Take connections for ever."""
        while True:
            near = self._listening.accept()[0]
            far = socket.socket()
            try:
                far.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
                far.connect(("127.0.0.1", self._target_port))
            except OSError:
                near.close()
                continue
            for one in (near, far):
                one.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER_BYTES)
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with self._lock:
                self._open += [near, far]
            for source, target in ((near, far), (far, near)):
                threading.Thread(target=self._carry, args=(source, target), daemon=True).start()

    def cut(self) -> None:
        """Break all connections."""
        with self._lock:
            for one in self._open:
                with suppress(OSError):
                    one.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _CUT)
                    one.shutdown(socket.SHUT_RDWR)
            self._open.clear()

    def _carry(self, source: socket.socket, target: socket.socket) -> None:
        due_s = time.monotonic()
        with suppress(OSError):
            while data := source.recv(_CHUNK_BYTES):
                target.sendall(data)
                due_s = max(due_s, time.monotonic() - 0.01) + len(data) / self._bytes_per_s
                time.sleep(max(0.0, due_s - time.monotonic()))
        for one in (source, target):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)


class RunningLink:
    """A relay in a process of its own."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        assert process.stdout is not None
        assert process.stdin is not None
        self._orders = process.stdin
        self.port = int(process.stdout.readline())

    def cut(self) -> None:
        """Break all connections."""
        self._orders.write("cut\n")
        self._orders.flush()


@contextmanager
def slow_link(target_port: int, bytes_per_s: float) -> Iterator[RunningLink]:
    """Carry connections to a port of this machine in a process of its own while entered."""
    command = [sys.executable, "-m", "testbed.slow_link", str(target_port), str(bytes_per_s)]
    folder = Path(__file__).parents[1]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=folder) as process:
        try:
            yield RunningLink(process)
        finally:
            process.communicate()


def main() -> None:
    """Relay until standard input closes."""
    target_port, bytes_per_s = sys.argv[1:]
    link = SlowLink(int(target_port), float(bytes_per_s))
    threading.Thread(target=link.run, daemon=True).start()
    print(link.port, flush=True)
    for _ in sys.stdin:
        link.cut()


if __name__ == "__main__":
    main()
