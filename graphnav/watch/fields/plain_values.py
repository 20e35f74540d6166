"""Convert the complete values of a message to nested lists."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Return a value with arrays as nested lists; non-finite numbers become null."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return _nested(value, plain)


def nested(value: Any) -> Any:
    """Return a value with arrays as nested lists, including NaN and infinities."""
    return _nested(value, nested)


def _nested(value: Any, item_of: Callable[[Any], Any]) -> Any:
    if isinstance(value, dict):
        return {name: item_of(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [item_of(item) for item in value]
    return item_of(value.tolist()) if isinstance(value, np.ndarray) else value
