"""No packet ends a process that listens: what liblcm crashes on stays in the kernel."""

from __future__ import annotations

import random
import socket
import struct
import subprocess
import sys
from urllib.parse import urlsplit

import pytest

_LISTEN = """
import sys
from graphnav.core.bus import Bus
bus, received = Bus(sys.argv[1]), []
bus.subscribe_all(lambda channel, data: received.append(channel))
print("ready", flush=True)
while "END" not in received:
    bus.handle(1)
print(*(name for name in received if name.startswith("GOOD")))
"""


def unfragmented(rest: bytes) -> bytes:
    """Return the packet of an unfragmented message: its name, a zero, its bytes."""
    return b"LC02" + struct.pack(">I", 1) + rest


def fragment(number: int, offset: int, rest: bytes) -> bytes:
    """Return one of the two fragments of a message of 70,000 bytes."""
    return b"LC03" + struct.pack(">IIIHH", 7, 70_000, offset, number, 2) + rest


@pytest.mark.parametrize(
    "packets",
    [
        [unfragmented(b"")],
        [unfragmented(b"NAME")],
        [unfragmented(b"N" * 63), unfragmented(b"N" * 64), unfragmented(b"N" * 5000)],
        [fragment(0, 0, b"NAME"), fragment(0, 0, b""), fragment(0, 0, b"")[:13], fragment(1, 0xFFFF_FFF0, b"x" * 99)],
        [b"", b"LC02", b"LC03", b"LC0", b"\0" * 8],
    ],
    ids=["header alone", "a name that does not end", "long names", "fragments", "no message"],
)
def test_a_listener_survives_and_hears_what_follows(packets: list[bytes], group: str) -> None:
    assert heard_after(packets, group) == ["GOOD", "GOOD" + "D" * 59, "GOOD.LARGE"]


def test_a_listener_survives_packets_of_random_bytes(group: str) -> None:
    chance = random.Random(5)
    packets = [unfragmented(chance.randbytes(chance.randrange(80)).replace(b"\0", b"\1")) for _ in range(2000)]
    assert heard_after(packets, group) == ["GOOD", "GOOD" + "D" * 59, "GOOD.LARGE"]


def heard_after(packets: list[bytes], group: str) -> list[str]:
    """Return the channels of three good messages that a listener receives after ``packets``."""
    address = urlsplit(group).hostname, urlsplit(group).port
    words = [sys.executable, "-c", _LISTEN, group]
    with (
        subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as listener,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
    ):
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        assert listener.stdout is not None
        assert listener.stdout.readline() == "ready\n"
        for packet in packets:
            sender.sendto(packet, address)
        for packet in (
            unfragmented(b"GOOD\0data"),
            unfragmented(b"GOOD" + b"D" * 59 + b"\0data"),
            fragment(0, 0, b"GOOD.LARGE\0" + b"x" * 60_000),
            fragment(1, 60_000, b"x" * 10_000),
            unfragmented(b"END\0"),
        ):
            sender.sendto(packet, address)
        printed = listener.stdout.read()
        assert listener.wait() == 0
    return printed.split()
