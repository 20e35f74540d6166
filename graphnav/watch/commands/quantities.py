"""Parse the values of options: ``100MB``, ``12.3s``."""

from __future__ import annotations

import argparse
import math
import re
from typing import TYPE_CHECKING

from graphnav.core.parameters import MAX_S

if TYPE_CHECKING:
    from graphnav.core.record import Split

_MAX_BYTES = 1e18
_PREFIXES = {"": 0, "k": 1, "m": 2, "g": 3, "t": 4}
_SIZE = re.compile(r"([0-9.]+) *([kmgt]?)(i?)b", re.IGNORECASE)
_TIME = re.compile(r"([0-9.]+) *(s|min|h)?")
_SECONDS = {None: 1, "s": 1, "min": 60, "h": 3600}


def size(text: str) -> int:
    """Parse a size, ``100MB`` or ``0.5GiB``, into at least one byte."""
    found = _SIZE.fullmatch(text.strip())
    number = _number(found[1]) if found else None
    if found is None or number is None:
        raise argparse.ArgumentTypeError(f"'{text}' is not a size: write 100MB or 2GiB")
    n_bytes = number * (1024 if found[3] else 1000) ** _PREFIXES[found[2].lower()]
    if not 1 <= n_bytes <= _MAX_BYTES:
        raise argparse.ArgumentTypeError(f"'{text}' is less than a byte, or more than {_MAX_BYTES:g} bytes")
    return int(n_bytes)


def log_time(text: str) -> float:
    """Parse a time, ``12.3s``, ``12.3`` or ``2min``, into seconds; 0 is allowed."""
    found = _TIME.fullmatch(text.strip())
    number = _number(found[1]) if found else None
    if found is None or number is None:
        raise argparse.ArgumentTypeError(f"'{text}' is not a time: write 12.3s or 2min")
    if number * _SECONDS[found[2]] > MAX_S:
        raise argparse.ArgumentTypeError(f"'{text}' is longer than {MAX_S:g} s")
    return number * _SECONDS[found[2]]


def period(text: str) -> float:
    """Parse a period above 0, ``0.5s``, into seconds."""
    if (value := log_time(text)) >= 1e-6:
        return value
    raise argparse.ArgumentTypeError(f"'{text}' is not a time above 0: write 0.5s")


def split(text: str) -> Split:
    """Parse the size or time of a part of a log: ``100MB`` or ``60s``."""
    from graphnav.core.record import Split

    try:
        return Split(n_bytes=size(text))
    except argparse.ArgumentTypeError:
        pass
    found = _TIME.fullmatch(text.strip())
    number = _number(found[1]) if found and found[2] else None
    if found is None or not number or number * _SECONDS[found[2]] > MAX_S:
        raise argparse.ArgumentTypeError(f"'{text}' is not a size or time: write 100MB or 60s")
    return Split(us=round(number * _SECONDS[found[2]] * 1e6))


def _number(digits: str) -> float | None:
    try:
        number = float(digits)
    except ValueError:
        return None
    return number if math.isfinite(number) else None
