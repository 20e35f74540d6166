"""Limit a speed and its growth."""

from __future__ import annotations

import math


def limited(wanted: float, last: float, max_value: float | None, growth_per_s: float | None, elapsed_s: float) -> float:
    """Return ``wanted``, reduced to the limits; None for no limit.

    Applies to both directions alike. ``last``: the previous output, ``elapsed_s`` ago. Only growth is limited: slowing
    down is immediate, a change of direction begins at zero.
    """
    size = abs(wanted)
    if max_value is not None:
        size = min(size, max_value)
    if growth_per_s is not None:
        begin = abs(last) if last * wanted > 0.0 else 0.0
        size = min(size, begin + growth_per_s * elapsed_s)
    return math.copysign(size, wanted)
