"""A relay of the packets of one LCM group to another, which loses some of them as a bad network does.

``python -m testbed.lossy SOURCE_GROUP SOURCE_PORT TARGET_GROUP TARGET_PORT RATIO SEED`` goes on until standard input
closes, then prints how many packets came and how many of them it lost.
"""

from __future__ import annotations

import json
import random
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

Group = tuple[str, int]
"""Address and port."""
_ALL_GROUPS = 49
"""IP_MULTICAST_ALL of Linux: off, packets of other groups on the same port do not arrive."""
_PACKET_BYTES = 65_536
_BUFFER_BYTES = 8 << 20


def url_of(group: Group) -> str:
    """Return the URL of a group for LCM, with the buffer that graphnav asks for."""
    return f"udpm://{group[0]}:{group[1]}?ttl=0&recv_buf_size=2097152"


class LossyRelay:
    """Carries packets; ``came`` and ``lost`` count them."""

    def __init__(self, source: Group, target: Group, ratio: float, seed: int) -> None:
        self.came = self.lost = 0
        self._target, self._ratio, self._random = target, ratio, random.Random(seed)
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
        self._in.setsockopt(socket.IPPROTO_IP, _ALL_GROUPS, 0)
        self._in.bind(("", source[1]))
        membership = struct.pack("=4sl", socket.inet_aton(source[0]), socket.INADDR_ANY)
        self._in.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)

    def run(self) -> None:
        """Carry for ever."""
        while True:
            packet = self._in.recv(_PACKET_BYTES)
            self.came += 1
            if self._random.random() < self._ratio:
                self.lost += 1
            else:
                self._out.sendto(packet, self._target)


@contextmanager
def lossy(source: Group, target: Group, ratio: float, seed: int) -> Iterator[dict[str, int]]:
    """Carry packets in a process of its own while entered; the mapping has ``came`` and ``lost`` afterwards."""
    words = map(str, (*source, *target, ratio, seed))
    command = [sys.executable, "-m", "testbed.lossy", *words]
    folder = Path(__file__).parents[1]
    counts: dict[str, int] = {}
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=folder) as process:
        assert process.stdout is not None
        process.stdout.readline()  # it listens
        try:
            yield counts
        finally:
            counts |= json.loads(process.communicate()[0])


def main() -> None:
    """Relay until standard input closes."""
    source, source_port, target, target_port, ratio, seed = sys.argv[1:]
    relay = LossyRelay((source, int(source_port)), (target, int(target_port)), float(ratio), int(seed))
    threading.Thread(target=relay.run, daemon=True).start()
    print("listens", flush=True)
    sys.stdin.read()
    print(json.dumps({"came": relay.came, "lost": relay.lost}))


if __name__ == "__main__":
    main()
