"""Time series of a channel's numbers, for plots."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from graphnav.watch.feed import KEPT_MESSAGES, Received

Path = tuple[str | int, ...]
"""The path to a value in a message: field names and indices."""

_MAX_NUMBERS = 64
_MAX_DEPTH = 4
_FEW = 4
"""The elements of arrays up to this size, such as forces and poses, are separate numbers."""
_MAX_INTEGER = 1 << 64
_ENVELOPE = {"utime", "seq"}


def path_text(path: Path) -> str:
    """Return a path in text form: ``stages[0].p50_ms``."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path).removeprefix(".")


def numbers_of(values: Mapping[str, Any]) -> dict[Path, float]:
    """Return the scalar numbers of a message, at most 64, except timestamp and sequence number."""
    return {path: float(number) for path, number in _first_numbers(values)}


def measures_of(values: Mapping[str, Any]) -> list[Path]:
    """Return the paths of a message's measurements: its numbers that are not integers."""
    return [path for path, number in _first_numbers(values) if isinstance(number, float)]


def _first_numbers(values: Mapping[str, Any]) -> Iterator[tuple[Path, int | float]]:
    found = ((path, number) for path, number in _numbers(values, ()) if path[0] not in _ENVELOPE)
    return itertools.islice(found, _MAX_NUMBERS)


def _numbers(value: Any, path: Path) -> Iterator[tuple[Path, int | float]]:
    if isinstance(value, bool | int | float):
        if isinstance(value, float) or abs(value) < _MAX_INTEGER:
            yield path, value
    elif len(path) >= _MAX_DEPTH:
        return
    elif isinstance(value, Mapping):
        for name, item in value.items():
            yield from _numbers(item, (*path, name))
    elif isinstance(value, np.ndarray) and value.dtype != object and value.ndim == 1 and value.size <= _FEW:
        for index, number in enumerate(value.tolist()):
            yield (*path, index), number
    elif isinstance(value, tuple):
        for index, item in enumerate(value[:_FEW]):
            yield from _numbers(item, (*path, index))


class Series:
    """Times and numbers of the last 600 messages of one channel."""

    def __init__(self) -> None:
        self.newest_s = -math.inf
        self._points: dict[Path, deque[tuple[float, float]]] = {}

    def clear(self) -> None:
        """Forget everything."""
        self.newest_s = -math.inf
        self._points.clear()

    def add(self, decoded: Iterable[tuple[Received, Mapping[str, Any] | None]]) -> None:
        """Add messages, oldest first, with their fields; None for undecodable ones."""
        for received, values in decoded:
            self.newest_s = received.at_s
            for path, number in numbers_of(values or {}).items():
                points = self._points.get(path)
                if points is None:
                    if len(self._points) >= _MAX_NUMBERS:
                        continue
                    points = self._points[path] = deque(maxlen=KEPT_MESSAGES)
                points.append((received.at_s, number))

    @property
    def paths(self) -> list[Path]:
        """The paths that can be plotted, in message order."""
        return list(self._points)

    def points(self, path: Path) -> list[tuple[float, float]]:
        """Return times (seconds) and finite numbers."""
        return [point for point in self._points.get(path, ()) if math.isfinite(point[1])]
