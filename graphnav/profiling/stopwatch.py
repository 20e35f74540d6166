"""Divide the time of a tick among nested spans: their sum is the tick, exactly."""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import StrEnum

from graphnav.runner.durations import Durations


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
        self.n_boundaries = 0
        self._clock = clock
        self._top = self.root
        self._last_ns = 0
        self._passed: list[tuple[Span, int]] = []
        self._entered: list[Span] = []

    @property
    def name(self) -> str:
        """The name of the current span."""
        return self._top.name

    def begin(self) -> None:
        """Begin a tick; forget one that did not end."""
        self._passed.clear()
        self._entered.clear()
        self._top = self.root
        self.is_on = True
        self._last_ns = self._clock()

    def end(self) -> None:
        """End the tick and count it."""
        self._passed.append((self._top, self._clock() - self._last_ns))
        self.is_on = False
        sums: dict[Span, int] = {}
        for span, ns in self._passed:
            sums[span] = sums.get(span, 0) + ns
        for span, ns in sums.items():
            span.ns += ns
            if span.part is Part.STEP:
                span.ticks.add(ns / 1e9)
        for span in self._entered:
            span.count += 1
        self.root.count += 1
        self.root.ticks.add(sum(sums.values()) / 1e9)
        self.n_ticks += 1
        self.n_boundaries += len(self._passed)

    def enter(self, part: Part, name: str) -> None:
        """Open a span within the current one."""
        span = self._child(part, name)
        self._entered.append(span)
        now_ns = self._clock()
        self._passed.append((self._top, now_ns - self._last_ns))
        self._top, self._last_ns = span, now_ns

    def leave(self) -> None:
        """Close the current span."""
        now_ns = self._clock()
        self._passed.append((self._top, now_ns - self._last_ns))
        self._top, self._last_ns = self._top.parent or self.root, now_ns

    def close(self, part: Part) -> None:
        """Close the current span if it is of this part."""
        if self._top.part is part:
            self.leave()

    def lap(self, part: Part, name: str) -> None:
        """Give the time since the last boundary to a span within the current one."""
        span = self._child(part, name)
        self._entered.append(span)
        now_ns = self._clock()
        self._passed.append((span, now_ns - self._last_ns))
        self._last_ns = now_ns

    def lap_of(self, part: Part, name: str, ns: int) -> None:
        """Give the last ``ns`` to a span within the current one; what came before belongs to the current one."""
        span = self._child(part, name)
        self._entered.append(span)
        now_ns = self._clock()
        passed_ns = now_ns - self._last_ns
        ns = min(max(ns, 0), passed_ns)
        self._passed += ((self._top, passed_ns - ns), (span, ns))
        self._last_ns = now_ns

    def _child(self, part: Part, name: str) -> Span:
        children = self._top.children
        span = children.get((part, name))
        if span is None:
            span = children[part, name] = Span(part, name, self._top)
        return span


def boundary_cost_us(pairs: int = 2000) -> float:
    """Return what one boundary of a stopwatch costs, microseconds: the mean over empty spans."""
    watch = Stopwatch()
    watch.begin()
    begin_ns = time.perf_counter_ns()
    for _ in range(pairs):
        watch.enter(Part.CHECK, "")
        watch.leave()
    return (time.perf_counter_ns() - begin_ns) / (2 * pairs) / 1e3
