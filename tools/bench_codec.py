"""Benchmark the codec against the Python of lcm-gen: medians of one process, and their ratio."""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from graphnav.core.codec import decode, encode
from graphnav.core.messages import Flow, Message, State, Twist

RNG = np.random.default_rng(0)
DECODE_AT_LEAST = 50.0
ENCODE_AT_LEAST = 5.0


def flow_of(rows: int, cols: int) -> Flow:
    """Return a dense flow."""
    uv_px = RNG.normal(size=(rows, cols, 2)).astype(np.float32)
    return Flow(uv_px=uv_px, valid=np.ones((rows, cols), np.uint8), interval_us=100_000)


CASES: dict[str, tuple[Message, int]] = {
    "flow 640x480": (flow_of(480, 640), 9),
    "flow 160x120": (flow_of(120, 160), 41),
    "state": (State(1.0, 2.0, 0.3, 0.3, 0.1, 0.5, contact=False, at_goal=False, moving=np.zeros((2, 3))), 2001),
    "twist": (Twist(v_mps=0.3, omega_radps=0.1), 2001),
}


def median_us(act: Callable[[], object], times: int) -> float:
    """Return the median duration, microseconds."""
    durations = []
    for _ in range(times):
        begin = time.perf_counter()
        act()
        durations.append(time.perf_counter() - begin)
    return statistics.median(durations) * 1e6


def measure(message: Message, times: int) -> tuple[float, float, float, float]:
    """Return medians, microseconds: our encoder, lcm-gen's, our decoder, lcm-gen's."""
    theirs: Any = message.lcm_class
    data = encode(message, 1, 2)
    made = theirs.decode(data)
    return (
        median_us(lambda: encode(message, 1, 2), 5 * times),
        median_us(made.encode, times),
        median_us(lambda: decode(type(message), data), 5 * times),
        median_us(lambda: theirs.decode(data), times),
    )


def main() -> int:
    """Print the results; return 1 if the 640x480 flow misses its target."""
    ratios: dict[str, tuple[float, float]] = {}
    print(
        f"{'message':14}"
        + "".join(f"{head:>12}" for head in ("encode us", "lcm-gen", "ratio", "decode us", "lcm-gen", "ratio"))
    )
    for name, (message, times) in CASES.items():
        times_us = measure(message, times)
        ratios[name] = (times_us[1] / times_us[0], times_us[3] / times_us[2])
        columns = (*times_us[:2], ratios[name][0], *times_us[2:], ratios[name][1])
        print(f"{name:14}" + "".join(f"{value:12.1f}" for value in columns))
    encode_ratio, decode_ratio = ratios["flow 640x480"]
    return 0 if encode_ratio >= ENCODE_AT_LEAST and decode_ratio >= DECODE_AT_LEAST else 1


if __name__ == "__main__":
    sys.exit(main())
