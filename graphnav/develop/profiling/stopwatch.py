"""Divide the time of a tick among nested spans: their sum is the tick, exactly."""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import StrEnum

from graphnav.core.runner import Durations


class Part(StrEnum):
    """A kind of work; ``STAGE`` and ``TICK`` have as their own time what none of the others accounts for."""

    TICK = "tick"
    STAGE = "stage"
    STEP = "step"
    CHECK = "check"
    ENCODE = "encode"
    DELIVER = "deliver"
    DECODE = "decode"
    LOG = "log"
    TAP = "tap"


class Span:
    """A part of the work for one stage or channel, within another; ``ns`` excludes the spans within it."""

    __slots__ = ("children", "count", "name", "ns", "parent", "part", "ticks")

    def __init__(self, part: Part, name: str, parent: Span | None) -> None:
        self.part, self.name, self.parent = part, name, parent
        self.children: dict[tuple[Part, str], Span] = {}
        self.ns = self.count = 0
        self.ticks = Durations()
        """How long a tick spent here, of ticks that did; kept for steps and for the tick itself."""


class Stopwatch:
    """Gives every nanosecond of a tick to exactly one span.

    A span is entered and left, as calls are; each boundary reads the clock once, and what has passed since the last
    boundary belongs to the span that was open. What a tick collected counts only when the tick ends: one that fails
    leaves no trace.

    ``clock``: nanoseconds.
    """

    def __init__(self, clock: Callable[[], int] = time.perf_counter_ns) -> None:
        self.root = Span(Part.TICK, "", None)
        self.is_on = False
        """Whether a tick is being measured."""
        self.n_ticks = 0
        self.n_readings = 0
        """How often the clock was read in ticks that ended."""
        self.clock = clock
        self._top = self.root
        self._ends: list[int] = []
        self._spans: list[Span] = []
        """The clock at every boundary, and the span that ended there: two lists, since an object for each boundary
        would make Python collect garbage."""
        self._entered: list[Span] = []

    @property
    def name(self) -> str:
        """The name of the current span."""
        return self._top.name

    def begin(self) -> None:
        """Begin a tick; forget one that did not end."""
        self._spans.clear()
        self._ends.clear()
        self._entered.clear()
        self._top = self.root
        self.is_on = True
        self._spans.append(self.root)
        self._ends.append(self.clock())

    def end(self) -> None:
        """End the tick and count it."""
        self._ends.append(self.clock())
        self._spans.append(self._top)
        self.is_on = False
        sums: dict[Span, int] = {}
        for span, end_ns, begin_ns in zip(self._spans[1:], self._ends[1:], self._ends, strict=False):
            sums[span] = sums.get(span, 0) + end_ns - begin_ns
        for span, ns in sums.items():
            span.ns += ns
            if span.part is Part.STEP:
                span.ticks.add(ns / 1e9)
        for span in self._entered:
            span.count += 1
        self.root.count += 1
        self.root.ticks.add((self._ends[-1] - self._ends[0]) / 1e9)
        self.n_ticks += 1
        self.n_readings += len(self._ends)

    def enter(self, part: Part, name: str) -> None:
        """Open a span within the current one."""
        span = self._child(part, name)
        self._entered.append(span)
        self._spans.append(self._top)
        self._top = span
        self._ends.append(self.clock())

    def leave(self) -> None:
        """Close the current span."""
        self._ends.append(self.clock())
        self._spans.append(self._top)
        self._top = self._top.parent or self.root

    def close(self, part: Part) -> None:
        """Close the current span if it is of this part."""
        if self._top.part is part:
            self.leave()

    def lap(self, part: Part, name: str) -> None:
        """Give the time since the last boundary to a span within the current one."""
        self._ends.append(self.clock())
        span = self._child(part, name)
        self._entered.append(span)
        self._spans.append(span)

    def _child(self, part: Part, name: str) -> Span:
        children = self._top.children
        span = children.get((part, name))
        if span is None:
            span = children[part, name] = Span(part, name, self._top)
        return span
