"""Send unwanted messages on a channel: a second writer's messages, or 20,000 a second, garbage or well-formed."""

from __future__ import annotations

import argparse
import random
import sys
import time

import graphnav_lcm
import lcm
from testbed.corrupt import CLASSES

SECOND_WRITER, GARBAGE, WELL_FORMED = "second writer", "20,000/s of garbage", "20,000/s, well-formed"
RATES_HZ = {SECOND_WRITER: 10.0, GARBAGE: 20_000.0, WELL_FORMED: 20_000.0}
_FIRST_SEQ = 100_000


def message_of(channel: str, kind: str, seq: int) -> bytes:
    """Return a message that differs from what the channel's own writer sends."""
    if kind == GARBAGE:
        return random.randbytes(60)
    message = CLASSES[channel]()
    message.utime, message.seq = time.time_ns() // 1000, seq
    if isinstance(message, graphnav_lcm.image_t):
        rows, cols = (120, 160) if kind == SECOND_WRITER else (8, 8)
        message.step_px, message.channels = 1, 1
        message.rows, message.cols, message.size = rows, cols, rows * cols
        message.data = random.randbytes(rows * cols)
    elif isinstance(message, graphnav_lcm.stop_t):
        message.engaged, message.reason = True, kind
    else:
        message.v_mps, message.omega_radps = -0.3, 1.0
    return bytes(message.encode())


def main() -> None:
    """Send for a while; print how many messages were sent."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("url")
    parser.add_argument("channel", choices=CLASSES)
    parser.add_argument("kind", choices=RATES_HZ)
    parser.add_argument("for_s", type=float)
    args = parser.parse_args()
    out = lcm.LCM(args.url)
    begin_s = time.monotonic()
    count = 0
    while (elapsed_s := time.monotonic() - begin_s) < args.for_s:
        for _ in range(min(200, int(elapsed_s * RATES_HZ[args.kind]) + 1 - count)):
            out.publish(args.channel, message_of(args.channel, args.kind, _FIRST_SEQ + count))
            count += 1
        time.sleep(0.0005 if args.kind != SECOND_WRITER else 0.01)
    sys.stdout.write(f"{count}\n")


if __name__ == "__main__":
    main()
