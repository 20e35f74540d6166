"""Pictures from one program to another by python-lcm alone: what `bench_edges.py` measures edges against.

``python tools/bare_edge.py URL ROWS COLS RATE_HZ S`` sends pictures from a process of its own and prints how long they
were on their way, as JSON.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time

import lcm
import numpy as np
from graphnav_lcm import image_t
from passing_stages import age_us, hop_statistics, timed_picture

CHANNEL = "EDGE"
_START_S = 1.0
"""How long the sender waits for the listener."""


def send(url: str, rows: int, cols: int, rate_hz: int, n: int) -> None:
    """Send so many pictures."""
    link = lcm.LCM(url)
    time.sleep(_START_S)
    begin_s = time.monotonic()
    for k in range(n):
        time.sleep(max(0.0, begin_s + k / rate_hz - time.monotonic()))
        pixels = timed_picture(rows, cols)
        message = image_t()
        message.utime, message.seq, message.step_px, message.rows, message.cols = k, k, 1, rows, cols
        message.channels, message.size, message.data = 1, rows * cols, pixels.tobytes()
        link.publish(CHANNEL, message.encode())


def hear(url: str, n: int, duration_s: float) -> dict[str, float]:
    """Return the statistics of what arrives."""
    hops_us: list[float] = []

    def take(_channel: str, data: bytes) -> None:
        message = image_t.decode(data)
        hops_us.append(age_us(np.frombuffer(message.data, np.uint8).reshape(message.rows, message.cols)))

    link = lcm.LCM(url)
    link.subscribe(CHANNEL, take).set_queue_capacity(0)
    end_s = time.monotonic() + duration_s + 2 * _START_S
    while len(hops_us) < n and time.monotonic() < end_s:
        link.handle_timeout(100)
    return hop_statistics(hops_us) if len(hops_us) > 1 else {"p50_us": np.inf, "p90_us": np.inf, "pictures": 0.0}


if __name__ == "__main__":
    url = sys.argv[1]
    rows, cols, rate_hz, seconds = map(int, sys.argv[2:6])
    if sys.argv[6:]:
        send(url, rows, cols, rate_hz, rate_hz * seconds)
    else:
        with subprocess.Popen([sys.executable, __file__, *sys.argv[1:6], "send"]):
            print(json.dumps(hear(url, rate_hz * seconds, seconds)))
