"""Listen to an LCM group for a moment, then send spoiled copies of what was heard on the same channels."""

from __future__ import annotations

import random
import sys
import time

from attacks.spoil import spoiled_bytes
from graphnav.core.bus import Bus
from graphnav.core.errors import BusError

_LISTEN_S = 2.0
_RATE_HZ = 400
_MAX_KEPT = 200
"""Messages of a channel that are kept."""
_NAMES = ("TELEOP", "STOP", "graphnav.status", "a\x1b[2Jb", "\u202e", "x" * 60)
"""Channels on which something is sent although nothing was heard."""


def send(url: str, seconds: float, seed: int) -> int:
    """Send for so many seconds; return how many messages were sent."""
    drawn = random.Random(f"sender {seed}")
    heard: dict[str, list[bytes]] = {}

    def keep(channel: str, data: bytes) -> None:
        kept = heard.setdefault(channel, [])
        if len(kept) < _MAX_KEPT:
            kept.append(data)

    bus = Bus(url)
    bus.subscribe_all(keep)
    end_s = time.monotonic() + _LISTEN_S
    while time.monotonic() < end_s:
        bus.drain()
        time.sleep(0.005)
    messages = [data for kept in heard.values() for data in kept] or [b"nothing was heard"]
    sender = Bus(url)
    count = 0
    end_s = time.monotonic() + seconds
    while time.monotonic() < end_s:
        channel = drawn.choice([*heard, *_NAMES])
        data = drawn.choice(heard.get(channel, messages) if drawn.random() < 0.8 else messages)
        try:
            sender.publish(channel, data if drawn.random() < 0.1 else spoiled_bytes(data, drawn))
            count += 1
        except BusError as error:
            print(error)
        time.sleep(1 / _RATE_HZ)
    return count


if __name__ == "__main__":
    print(send(sys.argv[1], float(sys.argv[2]), int(sys.argv[3])))
