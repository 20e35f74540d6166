"""Numbers as the report writes them."""

from __future__ import annotations

import math
from collections.abc import Sequence

from graphnav.ablation.digits import MOST_DECIMALS, decimals

_MOST_PLACES = 7
MINUS = "\N{MINUS SIGN}"


def number(value: float, places: int) -> str:
    """Return a number with so many places, zero without a sign."""
    text = f"{value:.{places}f}"
    return text.removeprefix("-") if float(text) == 0 else text.replace("-", MINUS)


def estimated(mean: float, low: float, high: float, *, signed: bool = False) -> str:
    """Return ``0.94 [0.84, 0.98]``; without an interval the mean alone."""
    places = decimals(mean, low, high)
    while low * high > 0 and places < _MOST_PLACES and float(f"{mean:.{places}f}") == 0:
        places += 1  # a clear difference is not told as none
    sign = "+" if signed and float(f"{mean:.{places}f}") > 0 else ""
    text = sign + number(mean, places)
    if not (math.isfinite(low) and math.isfinite(high)):
        return text
    return f"{text} [{number(low, places)}, {number(high, places)}]"


def counted(n: int, one: str, many: str = "") -> str:
    """Return ``1 world``, ``2 worlds``."""
    return f"{n} {one if n == 1 else many or one + 's'}"


def means_text(means: Sequence[float], *, signed: bool = False) -> str:
    """Return the least and the greatest of some means: ``0.86 to 0.98``."""
    ends = (min(means), max(means))
    places = max(2, -math.floor(math.log10(max(map(abs, ends))))) if any(ends) else 2
    texts = [("+" if signed and end > 0 else "") + number(end, min(places, MOST_DECIMALS)) for end in ends]
    return " to ".join(dict.fromkeys(texts))
