"""Limits of a speed and of how fast it grows."""

from __future__ import annotations

import math


def limited(wanted: float, last: float, most: float | None, growth_per_s: float | None, elapsed_s: float) -> float:
    """Return ``wanted``, or as much of it as the limits allow; None is no limit.

    Speeds forward and backward (turns to the left and to the right) alike. ``last``: what was let through before,
    ``elapsed_s`` ago. Only growth is limited: slowing down is immediate, a change of direction begins at zero.
    """
    size = abs(wanted)
    if most is not None:
        size = min(size, most)
    if growth_per_s is not None:
        begin = abs(last) if last * wanted > 0.0 else 0.0
        size = min(size, begin + growth_per_s * elapsed_s)
    return math.copysign(size, wanted)
