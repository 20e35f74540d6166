"""Draw counts as a row of bars."""

from __future__ import annotations

from collections.abc import Sequence

_BARS = "▁▂▃▄▅▆▇█"


def sparkline(counts: Sequence[int], width: int) -> str:
    """Return the newest ``width`` counts as bars from the right, the maximum as a full bar, 0 as a space."""
    newest = list(counts)[-width:] if width > 0 else []
    highest = max(newest, default=0)
    bars = [_BARS[-(-count * len(_BARS) // highest) - 1] if count else " " for count in newest]
    return "".join(bars).rjust(width)
