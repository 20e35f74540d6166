"""Hostile watch: whatever comes over the network is counted, shown as text, and neither crashes nor fills memory."""

from __future__ import annotations

import asyncio
import random
import socket
import struct
import tracemalloc
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from textual.pilot import Pilot

from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.messages import Flow, Image, Map, Message, Plane, State, Status, Steering
from graphnav.watch.feed import MAX_CHANNELS, Feed, Received, Watch
from graphnav.watch.spy.live_watch import LiveWatch
from graphnav.watch.spy.screen import SpyApp

from .spy_app import until

SHORT_MAGIC = 0x4C433032
"""The magic number of an unfragmented LCM packet."""
GRID, VALID = np.ones((4, 5, 2), np.float32), np.ones((4, 5), np.uint8)
FORCE = np.array([0.1, 0.2])
MESSAGES: list[Message] = [
    Image(VALID),
    Flow(GRID, VALID, 1),
    Plane(VALID, GRID[..., 0], VALID, 1, 0.5),
    State(0, 0, 0, 0, 0, 0, contact=False, at_goal=False, moving=np.zeros((1, 3))),
    Steering(FORCE, FORCE, FORCE, 0.1, FORCE),
    Status("run", "graph", False, 0, 0, 0, 0, 0, 0, "", (), (), (), ()),
    Map(
        VALID[0], np.ones(5), np.ones((5, 2)), np.arange(5, dtype=np.int32), np.zeros(3), np.ones((3, 2)), 0.1, 1.0,
        np.ones((3, 2)),
    ),
]  # fmt: skip
NAMES = [f"c{k}" for k in range(8)] + ["[red]x", "\x1b]0;title\x07", "a\x00b", "\u202e", "x" * 63]


def mutated(rng: random.Random) -> tuple[str, bytes]:
    """Return a channel's name and a message that was flipped in places, cut, lengthened, or is only noise."""
    data = bytearray(encode(rng.choice(MESSAGES), rng.getrandbits(62), rng.getrandbits(62)))
    for _ in range(rng.randrange(8)):
        data[rng.randrange(len(data))] = rng.getrandbits(8)
    how = rng.randrange(4)
    if how == 0:
        data = data[: rng.randrange(len(data))]
    elif how == 1:
        data += rng.randbytes(rng.randrange(20))
    name = rng.choice(NAMES) if rng.random() < 0.99 else f"n{rng.getrandbits(40)}"
    return name, bytes(data)


@pytest.mark.long
def test_every_message_is_counted_and_memory_stays_bounded() -> None:
    rng = random.Random(7)
    watch = Watch(lambda: 0.0)
    sizes = []
    tracemalloc.start()
    for part in range(3):
        for k in range(8000):
            name, data = mutated(rng)
            watch.receive(Received(name, data, part * 8000 + k))
        sizes.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    channels = watch.channels
    assert len(channels) <= MAX_CHANNELS
    assert sum(channel.count for channel in channels.values()) + watch.overflow == watch.count == 24_000
    undecodable = sum(channel.undecodable for channel in channels.values())
    assert 4000 < undecodable <= watch.undecodable <= undecodable + watch.overflow
    for channel in channels.values():
        assert channel.values is None or isinstance(channel.values, dict)
    assert sizes[2] - sizes[1] < 2_000_000


def packet(channel: bytes, data: bytes) -> bytes:
    """Return a packet of LCM with one message."""
    return struct.pack(">II", SHORT_MAGIC, 1) + channel + b"\0" + data


@pytest.mark.long
def test_the_screen_lives_through_a_flood(group: str) -> None:
    parts = urlsplit(group)
    address = (parts.hostname, parts.port)

    async def act(pilot: Pilot[None], watch: LiveWatch) -> None:
        rng = random.Random(11)
        bus = Bus(group)
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for k in range(10):
            for _ in range(200):
                name, data = mutated(rng)
                if "\0" not in name:
                    bus.publish(name, data)
                sender.sendto(rng.randbytes(rng.randrange(200)), address)
                sender.sendto(packet(rng.randbytes(rng.randrange(1, 70)), data), address)
            if k == 5:
                await pilot.press("s", "S")
            await pilot.press("down", "enter", "v", "escape")
        await until(pilot, lambda: len(watch.rows()) > len(NAMES) / 2)
        assert watch.failure == ""
        assert len(watch.rows()) <= MAX_CHANNELS
        sender.close()
        bus.close()

    async def body() -> None:
        watch = LiveWatch(Feed(group))
        watch.start()
        try:
            async with SpyApp(watch, Catalog(), Path.cwd()).run_test(size=(120, 40)) as pilot:
                await act(pilot, watch)
        finally:
            watch.close()

    asyncio.run(body())


def test_a_name_that_is_not_utf_8_does_not_end_the_watch(group: str) -> None:
    parts = urlsplit(group)
    watch = LiveWatch(Feed(group))
    watch.start()
    bus = Bus(group)
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            while watch.channel("after") is None:
                sender.sendto(packet(b"\xff\xfe\xfd", b"x" * 20), (parts.hostname, parts.port))
                bus.publish("after", encode(MESSAGES[0], 0, 0))
                assert watch.failure == ""
    finally:
        watch.close()
        bus.close()
