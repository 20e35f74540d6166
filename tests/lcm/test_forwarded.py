"""A message that was forwarded from another host is heard by all programs, and forwarded by none of them again."""

from __future__ import annotations

import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial

import pytest

from graphnav.core.bus import Bus
from graphnav.core.errors import BusError
from graphnav.core.large_messages.child import FORWARDED

_HEAR = """
import sys
from graphnav.core.bus import Bus
bus, heard = Bus(sys.argv[1], forwards=True), []
bus.subscribe_all(lambda channel, data: heard.append(channel))
print("ready", flush=True)
while "END" not in heard:
    bus.handle(1)
print(*heard)
"""
LARGE = 922_000


@pytest.fixture
def opened(far_group: str) -> Iterator[Callable[..., Bus]]:
    """Return what opens buses of a group in which no motor process of an earlier test still sends."""
    buses = []

    def open_bus(*, forwards: bool) -> Bus:
        buses.append(Bus(far_group, forwards=forwards))
        return buses[-1]

    yield open_bus
    for bus in buses:
        bus.close()


def heard_by(*buses: Bus) -> list[list[tuple[str, int]]]:
    """Return lists that fill with the channels and sizes of the messages that each bus hears."""
    heard: list[list[tuple[str, int]]] = [[] for _ in buses]
    for bus, of_bus in zip(buses, heard, strict=True):
        bus.subscribe_all(partial(_hear, of_bus))
    return heard


def _hear(of_bus: list[tuple[str, int]], channel: str, data: bytes) -> None:
    of_bus.append((channel, len(data)))


def until_end(buses: list[Bus], heard: list[list[tuple[str, int]]]) -> None:
    """Handle messages until all have heard the last one."""
    end_s = time.monotonic() + 30
    while not all(("END", 3) in of_bus for of_bus in heard) and time.monotonic() < end_s:
        for bus in buses:
            bus.handle(0.01)


def test_what_is_forwarded_is_heard_by_others_and_not_forwarded_again(opened: Callable[..., Bus]) -> None:
    plain, tunnel, other = opened(forwards=False), opened(forwards=True), opened(forwards=True)
    heard = heard_by(tunnel, other, plain)  # one that forwards nothing is last: it filters this process's sockets, too
    for bus, name in ((plain, "PLAIN"), (tunnel, "TUNNEL"), (other, "OTHER")):
        bus.send(name, bytes(100))
        bus.send(f"{name}.LARGE", bytes(LARGE))
    plain.send("END", b"end")
    until_end([plain, tunnel, other], heard)
    own = [("PLAIN", 100), ("PLAIN.LARGE", LARGE), ("END", 3)]
    assert heard[0] == own
    assert heard[1] == own
    assert sorted(heard[2]) == sorted(
        [*own, ("TUNNEL", 100), ("TUNNEL.LARGE", LARGE), ("OTHER", 100), ("OTHER.LARGE", LARGE)]
    )
    assert tunnel.dropped_packets() == other.dropped_packets() == 0  # what it does not hear is not lost


def test_a_tunnel_of_another_process_does_not_forward_it_either(far_group: str, opened: Callable[..., Bus]) -> None:
    plain, tunnel = opened(forwards=False), opened(forwards=True)
    words = [sys.executable, "-c", _HEAR, far_group]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        process.stdout.readline()
        for k in range(2 * FORWARDED[1]):  # all of the numbers
            tunnel.publish("FORWARDED", bytes(k))
        plain.publish("PLAIN", b"")
        plain.publish("END", b"end")
        assert process.stdout.read().split() == ["PLAIN", "END"]


@pytest.mark.parametrize("name", ["N" * 64, "A\0B"], ids=["long", "null"])
def test_a_name_that_lcm_does_not_take_is_refused(name: str, opened: Callable[..., Bus]) -> None:
    with pytest.raises(BusError, match="cannot publish 3 bytes"):
        opened(forwards=True).publish(name, b"abc")


def test_a_bus_is_polled_by_its_descriptor(opened: Callable[..., Bus]) -> None:
    bus = opened(forwards=True)
    heard = heard_by(bus)
    assert not select.select([bus.fileno()], [], [], 0)[0]
    opened(forwards=False).publish("END", b"end")
    assert select.select([bus.fileno()], [], [], 30)[0]
    assert bus.handle(0.0)
    assert heard == [[("END", 3)]]
