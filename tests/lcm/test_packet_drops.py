"""What the kernel drops of a group is told by everything that listens there."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import closing
from urllib.parse import urlsplit

from graphnav.bus import Bus
from graphnav.recorder.listener import Listener
from graphnav.spy import Feed, Traffic, as_json, drops_of
from graphnav.spy.live_watch import LiveWatch

DROPPED = b"LC02\0\0\0\1"
"""A packet that the bus has the kernel drop: LCM would crash on it."""
PATIENCE_S = 30.0


def send(group: str, packet: bytes) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        sender.sendto(packet, (urlsplit(group).hostname, urlsplit(group).port))


def until(holds: Callable[[], bool]) -> None:
    end_s = time.monotonic() + PATIENCE_S
    while not holds():
        assert time.monotonic() < end_s, "it never came to that"
        time.sleep(0.01)


def test_a_bus_counts_what_the_kernel_drops_and_nothing_else(group: str) -> None:
    with closing(Bus(group)) as bus:
        heard: list[str] = []
        bus.subscribe_all(lambda channel, _: heard.append(channel))
        for packet in (b"", b"LC0", b"LC02", b"LC02aaa", DROPPED[:8] + b"n" * 64, DROPPED, DROPPED + b"name"):
            send(group, packet)
        bus.publish("end", b"")
        until(lambda: bus.handle(0.01) or "end" in heard)
        assert bus.dropped_packets() == 2


def test_inside_a_process_nothing_is_dropped() -> None:
    bus = Bus()
    bus.subscribe_all(lambda *_: None)
    assert bus.dropped_packets() == 0


def test_a_feed_tells_it_also_after_its_end(group: str) -> None:
    feed = Feed(group)
    assert drops_of(feed) == ""
    with closing(feed.listen(None)) as heard:
        next(heard)
        send(group, DROPPED)
        until(lambda: feed.dropped_packets() == 1)
        assert drops_of(feed) == "1 packet dropped by the kernel"
        send(group, DROPPED)
        until(lambda: feed.dropped_packets() == 2)
    assert drops_of(feed) == "2 packets dropped by the kernel"
    assert as_json(Traffic(), feed)["dropped_packets"] == 2


def test_the_heading_of_the_spy_begins_with_it(group: str) -> None:
    feed = Feed(group)
    watch = LiveWatch(feed)
    watch.start()
    bus = Bus(group)

    def is_listening() -> bool:
        bus.publish("x", b"")
        return watch.version != 0

    until(is_listening)
    send(group, DROPPED)
    until(lambda: watch.heading().startswith("1 packet dropped by the kernel  "))
    bus.close()
    watch.close()


def test_record_counts_it(group: str) -> None:
    listener = Listener(group, lambda *_: None)
    send(group, DROPPED)
    until(lambda: listener.dropped_packets() == 1)
    listener.start()
    listener.close()
