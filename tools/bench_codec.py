"""Benchmark the codec against the Python of lcm-gen, taking turns."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from taking_turns import Turns, load_told, take_turns, timed

from graphnav.core.codec import decode, encode
from graphnav.core.messages import Flow, Message, State, Twist

RNG = np.random.default_rng(0)


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


ENCODE, THEIR_ENCODE, DECODE, THEIR_DECODE = "encode", "lcm-gen encode", "decode", "lcm-gen decode"
TARGETS = ((ENCODE, THEIR_ENCODE, 5.0), (DECODE, THEIR_DECODE, 50.0))
"""Ours, theirs, and the ratio of theirs to ours for the 640x480 flow, at least."""


def measure(message: Message, rounds: int) -> Turns:
    """Return the times of our encoder and decoder, which take five messages a turn, and of lcm-gen's."""
    theirs: Any = message.lcm_class
    data = encode(message, 1, 2)
    rivals = {
        ENCODE: timed(lambda: encode(message, 1, 2), times=5),
        THEIR_ENCODE: timed(theirs.decode(data).encode),
        DECODE: timed(lambda: decode(type(message), data), times=5),
        THEIR_DECODE: timed(lambda: theirs.decode(data)),
    }
    return take_turns(rivals, rounds)


def main() -> int:
    """Print the results; return 1 if the 640x480 flow misses its target."""
    columns = ("encode us", "lcm-gen", "ratio", "decode us", "lcm-gen", "ratio")
    print(f"{'message':14}" + "".join(f"{head:>{27 if head == 'ratio' else 12}}" for head in columns))
    are_met = True
    for name, (message, rounds) in CASES.items():
        turns = measure(message, rounds)
        line = f"{name:14}"
        for ours, theirs, limit in TARGETS:
            ratio = turns.ratio(theirs, ours)
            are_met &= name != "flow 640x480" or ratio.median >= limit
            line += f"{1e6 * turns.median(ours):12.1f}{1e6 * turns.median(theirs):12.1f}{ratio!s:>27}"
        print(line)
    return 0 if are_met else 1


if __name__ == "__main__":
    with load_told():
        sys.exit(main())
