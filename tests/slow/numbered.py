"""Programs on either side of a tunnel: one sends numbered messages at a rate, one listens and tells what it heard.

``python numbered.py send URL CHANNEL RATE_HZ N_BYTES FOR_S``, ``python numbered.py hear URL CHANNEL``: until standard
input closes. Both end by a line of JSON.
"""

from __future__ import annotations

import json
import struct
import sys
import threading
import time

import lcm

from graphnav.core.bus import Bus

_NUMBER = struct.Struct(">Q")
_BURST_S = 0.002


def send(url: str, channel: str, rate_hz: float, n_bytes: int, for_s: float) -> dict[str, float]:
    """Send, in bursts of some milliseconds; large messages with gaps, as runs do."""
    bus = Bus(url)
    rest = bytes(n_bytes - _NUMBER.size)
    count, begin_s = 0, time.monotonic()
    while (now_s := time.monotonic() - begin_s) < for_s:
        while count < now_s * rate_hz:
            bus.send(channel, _NUMBER.pack(count) + rest, newest_only=True)
            count += 1
        time.sleep(_BURST_S)
    took_s = time.monotonic() - begin_s
    bus.close()
    return {"sent": count - bus.overtaken.get(channel, 0), "rate_hz": count / took_s}


def hear(url: str, channel: str) -> dict[str, float]:
    """Listen until standard input closes."""
    ending = threading.Event()
    threading.Thread(target=_await_end, args=(ending,), daemon=True).start()
    heard, last, unordered, twice, longest_s, at_s = 0, -1, 0, 0, 0.0, 0.0

    def take(_: str, data: bytes) -> None:
        nonlocal heard, last, unordered, twice, longest_s, at_s
        (number,) = _NUMBER.unpack_from(data)
        heard += 1
        unordered += number < last
        twice += number == last
        last, now_s = number, time.monotonic()
        longest_s = max(longest_s, now_s - at_s) if at_s else 0.0
        at_s = now_s

    ear = lcm.LCM(url)
    ear.subscribe(channel, take).set_queue_capacity(0)
    print("listens", flush=True)
    while not ending.is_set() or ear.handle_timeout(0):
        ear.handle_timeout(50)
    return {"heard": heard, "last": last, "unordered": unordered, "twice": twice, "longest_s": longest_s}


def _await_end(ending: threading.Event) -> None:
    sys.stdin.read()
    ending.set()


def main() -> None:
    """Do as told."""
    what, url, channel, *numbers = sys.argv[1:]
    done = (
        send(url, channel, float(numbers[0]), int(numbers[1]), float(numbers[2]))
        if what == "send"
        else hear(url, channel)
    )
    print(json.dumps(done), flush=True)


if __name__ == "__main__":
    main()
