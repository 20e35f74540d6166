"""Fire stages that a recorded live run did not have, by the firing rule of live runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

from graphnav.core.runner import LiveInbox, Taken, Timer, Unit

_MAX_GAP_S = 10.0
"""Timers do not fire in longer gaps of a log, whose timestamps may be damaged."""


class Due(NamedTuple):
    """A firing: its time, seconds of the run, and the stage."""

    at_s: float
    unit: Unit[LiveInbox]
    utime: int | None
    """The timestamp of its set of inputs, None if it publishes with the run's clock."""
    take: Callable[[], Taken | None]
    """Returns what it steps with, None if it does not step."""


class AddedStages:
    """Determines the next stage to fire, by log time.

    Steps take no time, so a stage fires at the time of the message that completes the newest set of its plain inputs,
    stages near the end of the graph first; later if the set waits for a `Since` input. Timers start at ``start_s``.
    """

    def __init__(self, units: Sequence[Unit[LiveInbox]], start_s: float) -> None:
        self._units = tuple(reversed(units))
        self._timers = [(Timer(Timer.every(u.node.every_ms / 1e3), start_s), u) for u in self._units if u.node.every_ms]
        self._now_s = start_s

    def next_due(self, to_s: float) -> Due | None:
        """Return the next firing up to a time, None if there is none."""
        for unit in self._units:
            if (due := self._ready(unit, self._now_s)) is not None:
                return due
        self._skip_gap(to_s)
        timer_s, timer, clocked = min(
            ((timer.due_s, timer, unit) for timer, unit in self._timers),
            key=lambda one: one[0],
            default=(math.inf, None, None),
        )
        waking_s = min((unit.inbox.wakes_at_s(unit.patience_s) for unit in self._units), default=math.inf)
        if min(timer_s, waking_s) > to_s:
            self._now_s = max(self._now_s, to_s)
            return None
        self._now_s = max(self._now_s, min(timer_s, waking_s))
        if timer is None or clocked is None or waking_s < timer_s:
            return self.next_due(to_s)
        timer.advance(self._now_s)
        return Due(self._now_s, clocked, None, partial(clocked.inbox.take_timer, self._now_s, clocked.patience_s))

    def _ready(self, unit: Unit[LiveInbox], now_s: float) -> Due | None:
        matched = unit.inbox.ready(now_s, unit.patience_s)
        if matched is None:
            return None
        utime = None if unit.inbox.is_clocked else matched.utime
        return Due(now_s, unit, utime, partial(unit.inbox.take_set, matched, now_s))

    def _skip_gap(self, to_s: float) -> None:
        for timer, _ in self._timers:
            if to_s - timer.due_s > _MAX_GAP_S:
                timer.advance(to_s)
