"""Every listener reports the packets that the kernel dropped."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import closing
from urllib.parse import urlsplit

import pytest

from graphnav.core.bus import Bus
from graphnav.core.errors import UserError
from graphnav.watch.feed import Feed, LiveFeed, Received, Watch, drops_of
from graphnav.watch.spy import as_json
from graphnav.watch.spy.live_watch import LiveWatch

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
        received: list[str] = []
        bus.subscribe_all(lambda channel, _: received.append(channel))
        for packet in (b"", b"LC0", b"LC02", b"LC02aaa", DROPPED[:8] + b"n" * 64, DROPPED, DROPPED + b"name"):
            send(group, packet)
        bus.publish("end", b"")
        until(lambda: bus.handle(0.01) or "end" in received)
        assert bus.dropped_packets() == 2


def test_inside_a_process_nothing_is_dropped() -> None:
    bus = Bus()
    bus.subscribe_all(lambda *_: None)
    assert bus.dropped_packets() == 0


def test_a_feed_tells_it_also_after_its_end(group: str) -> None:
    feed = Feed(group)
    assert drops_of(feed) == ""
    with closing(feed.listen(None)) as received:
        next(received)
        send(group, DROPPED)
        until(lambda: feed.dropped_packets() == 1)
        assert drops_of(feed) == "1 packet dropped by the kernel"
        send(group, DROPPED)
        until(lambda: feed.dropped_packets() == 2)
    assert drops_of(feed) == "2 packets dropped by the kernel"
    assert as_json(Watch(), feed)["dropped_packets"] == 2


def test_a_channel_that_is_not_heard_may_be_what_was_dropped(group: str) -> None:
    feed, watch = Feed(group), Watch()
    watch.receive(Received("control.twist", b"", 0.0))
    with closing(feed.listen(None)) as received:
        next(received)
        send(group, DROPPED)
        until(lambda: feed.dropped_packets() == 1)
        with pytest.raises(UserError) as raised:
            watch.find("BIG", feed, None)
    assert str(raised.value) == (
        f"{group} has no channel 'BIG'\n  channels are control.twist\n"
        "  1 packet dropped by the kernel, perhaps of this channel: run 'graphnav doctor'"
    )


def test_the_heading_of_the_spy_says_it_within_80_columns(group: str) -> None:
    feed = Feed(group)
    watch = LiveWatch(feed)
    watch.start()
    bus = Bus(group)

    def is_listening() -> bool:
        bus.publish("x", b"")
        return watch.version != 0

    until(is_listening)
    send(group, DROPPED)
    until(lambda: "dropped" in watch.heading())
    assert watch.heading().startswith(f"{group.partition('?')[0]}  1 channels  1 dropped  ")
    bus.close()
    watch.close()


def test_record_counts_it(group: str) -> None:
    listener = LiveFeed(Feed(group), lambda _: None)
    listener.open()
    send(group, DROPPED)
    until(lambda: listener.dropped_packets() == 1)
    listener.start()
    listener.close()
