"""Batch scalars into columns, which Rerun logs a hundred times faster than single values."""

from __future__ import annotations

import math
from typing import Any

from graphnav.watch.export.entries.entries import Scalars
from graphnav.watch.export.entries.topics import parts_of
from graphnav.watch.export.tables.scalar_fields import Leaf, leaves_of

_STAMPS = {"utime", "seq"}
_ROWS = 4096


class RerunColumns:
    """The scalars of one channel: numbers and booleans, except timestamps and array sizes.

    Non-finite values become NaN, which plots show as a gap.
    """

    def __init__(self, channel: str, lcm_class: type) -> None:
        self._parts = parts_of(channel)
        self._leaves = [leaf for leaf in leaves_of(lcm_class) if _is_plotted(leaf)]
        self._times_s: list[float] = []
        self._values: list[list[float]] = [[] for _ in self._leaves]

    def add(self, entry: Scalars, at_s: float) -> bool:
        """Add the scalars of a message; return whether to send the batch."""
        self._times_s.append(at_s)
        for leaf, values in zip(self._leaves, self._values, strict=True):
            value = float(leaf.of(entry.fields))
            values.append(value if math.isfinite(value) else math.nan)
        return len(self._times_s) >= _ROWS

    def send(self, rr: Any, stream: Any, timeline: str) -> None:
        """Send the batch."""
        index = rr.TimeColumn(timeline, duration=self._times_s)
        for leaf, values in zip(self._leaves, self._values, strict=True):
            entity = rr.new_entity_path([*self._parts, leaf.name])
            stream.send_columns(entity, indexes=[index], columns=rr.Scalars.columns(scalars=values))
            values.clear()
        self._times_s = []


def _is_plotted(leaf: Leaf) -> bool:
    return not leaf.is_size and leaf.name not in _STAMPS and leaf.primitive != "string"
