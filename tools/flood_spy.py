"""Flood the full-screen spy with mutated messages and packets of garbage; what it counts and what it takes."""

from __future__ import annotations

import argparse
import asyncio
import random
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

from graphnav.core.bus import Bus
from graphnav.core.catalog import Catalog
from graphnav.core.codec import encode
from graphnav.core.messages import About, Message, Status, Stop, Twist
from graphnav.watch.feed import Feed
from graphnav.watch.spy.live_watch import LiveWatch
from graphnav.watch.spy.screen import SpyApp

GROUP = "udpm://239.255.78.9:7709?ttl=0"
_MAGIC = 0x4C433032
"""Magic number of a packet with a complete message; the next number is that of a fragment. LCM's own library (1.5)
ends the process at a packet of the first kind without any zero byte, in any receiver: garbage with this number ends
with one here."""
_HEADER = struct.Struct(">II")
_MAX_NAME = 63
_NAMES = ("[red]x", "\x1b[2J", "\x1b]0;owned\x07", "a b", "[/]", "<img src=x onerror=alert(1)>", "\r\x08\u202e")
_DIFFERENT = 20_000
_PER_PAUSE = 50
_PAUSE_S = 0.005


def flood(url: str, count: int, seed: int) -> int:
    """Send ``count`` mutated messages and as many packets of garbage; return how many of the latter are messages."""
    rng = random.Random(seed)
    parts = urlsplit(url)
    address = (parts.hostname, parts.port)
    bus = Bus(url)
    messages = [_mutated(rng) for _ in range(_DIFFERENT)]
    garbage = [rng.randbytes(rng.randrange(300)) for _ in range(_DIFFERENT // 2)]
    garbage += [_HEADER.pack(_MAGIC + rng.randrange(2), 1) + one + b"\0" for one in garbage]
    is_message = [_is_message(one) for one in garbage]
    n_messages = 0
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for k in range(count):
            bus.publish(*messages[k % _DIFFERENT])
            sender.sendto(garbage[k % _DIFFERENT], address)
            n_messages += is_message[k % _DIFFERENT]
            if k % _PER_PAUSE == 0:
                time.sleep(_PAUSE_S)
    bus.close()
    return n_messages


def _is_message(packet: bytes) -> bool:
    """Whether LCM takes a packet for a message: a short one, with a name of 63 bytes at most that is UTF-8."""
    name, zero, _ = packet[_HEADER.size :].partition(b"\0")
    if not zero or len(name) > _MAX_NAME or _HEADER.unpack_from(packet)[0] != _MAGIC:
        return False
    try:
        name.decode()
    except UnicodeDecodeError:
        return False
    return True


def _mutated(rng: random.Random) -> tuple[str, bytes]:
    name = rng.choice(_NAMES) if rng.random() < 0.9 else f"n{rng.randrange(10**6)}"
    message: Message = rng.choice(
        [
            Twist(1, 2),
            Stop(engaged=True, reason="[bold]\x1b[31m<script>alert(2)</script>"),
            Status("run", "g", False, 0, 0, 0, 0, 0, 0, "", (), (), (), ()),  # noqa: FBT003
            About("[red]", "", f"\x1b{rng.random()}", 1, (name,), ("x.y_t",)),
        ]
    )
    data = bytearray(encode(message, rng.getrandbits(60), rng.getrandbits(60)))
    for _ in range(rng.randrange(6)):
        data[rng.randrange(len(data))] = rng.getrandbits(8)
    return name, bytes(data[: rng.randrange(len(data))] if rng.random() < 0.5 else data)


def _rss_mb() -> float:
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * 4096 / 1e6


async def watch_flood(count: int) -> None:
    """Run the spy without a terminal while another process floods it; print what was counted."""
    watch = LiveWatch(Feed(GROUP))
    watch.start()
    async with SpyApp(watch, Catalog(), Path.cwd()).run_test(size=(200, 50)) as pilot:
        await pilot.pause(1.0)
        begin_s, begin_mb = time.monotonic(), _rss_mb()
        with subprocess.Popen([sys.executable, __file__, "--send", GROUP, "--count", str(count)]) as sender:
            while sender.poll() is None:
                await pilot.pause(0.5)
                await pilot.press("down", "enter")
                await pilot.pause(0.5)
                await pilot.press("escape")
        await pilot.pause(2.0)
        rows = watch.rows()
        print(
            f"{count} mutated messages and {count} packets of garbage in {time.monotonic() - begin_s:.0f} s: "
            f"{watch.version} counted, on {len(rows)} channels and beside them, "
            f"{sum(row.undecodable for row in rows)} of those kept undecodable, failure '{watch.failure}', "
            f"memory {begin_mb:.0f} MB before, {_rss_mb():.0f} MB after"
        )
    watch.close()


def main() -> None:
    """Flood, or watch the flood."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=10**6)
    parser.add_argument("--send", metavar="URL", help="only send, and print how many packets of garbage are messages")
    args = parser.parse_args()
    if args.send:
        print(flood(args.send, args.count, 7))
    else:
        asyncio.run(watch_flood(args.count))


if __name__ == "__main__":
    main()
