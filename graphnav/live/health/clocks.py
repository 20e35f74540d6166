"""Diagnose the clocks of a live run's senders: units, offsets, and stamps that cannot be joined."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

from graphnav import Graph
from graphnav.core.machine import NOTABLE_OFFSET_S, SET_ALIKE, side_text, span_text
from graphnav.live.inputs.sender_monitor import SenderMonitor
from graphnav.live.live_schedule import LiveSchedule

_MIN_ACCEPTED = 5
"""Messages after which the smallest delay is an estimate of the offset."""
_NEWS_RATIO = 0.5
"""An offset that has changed by less than this share of itself, or by less than 0.2 s, is not reported again."""
_HALF_HOUR_S, _LOCAL_TIME_S, _MAX_LOCAL_H = 1800.0, 60.0, 14
"""Clocks in local time differ by half hours, which a clock without NTP keeps to a minute."""
_SYNC = f"\n  {SET_ALIKE}"
_YEAR_S = 365 * 86_400.0


class _Pair(NamedTuple):
    """Two inputs whose stamps a stage joins; ``is_sampled``: the second one is read as `Since`."""

    stage: str
    first: str
    second: str
    is_sampled: bool


class Clocks:
    """Says what is wrong with the stamps of the inputs, in place of what follows from it: stale, repeated, overtaken.

    ``notes``: the newest note on the clock of each input, by reference; faults of stamps are in the input's monitor.
    ``is_troubled``: whether stamps are wrong or cannot be joined, so that messages wait in vain.
    """

    def __init__(self, schedule: LiveSchedule) -> None:
        self.notes: dict[str, str] = {}
        self.is_troubled = False
        self._schedule = schedule
        self._pairs = list(_pairs(schedule.graph))
        self._told: dict[str, tuple[str, float]] = {}

    def look(self) -> Iterator[str]:
        """Yield what is new since the last call."""
        self.is_troubled, self.notes = False, {}
        for ref, intake in self._schedule.intakes.items():
            who = f"{ref} on {intake.source.name}"
            if fault := intake.monitor.stamp_fault:
                self.is_troubled = True
                yield from self._news(ref, f"{who}: {fault}")
            elif intake.monitor.accepted >= _MIN_ACCEPTED and intake.source.log is None:
                yield from self._offset(ref, who, intake.monitor)
        for pair in self._pairs:
            yield from self._apart(pair)
        for name, unit in self._schedule.engine.units.items():
            join = unit.inbox.join
            if join.never_matches:
                self.is_troubled = True
                gap_s = join.gap_us() * 1e-6
                yield from self._news(
                    f"{name} joins",
                    f"{name} joins nothing: {', '.join(join.unmatched)} have no stamp in common, the nearest differ by "
                    f"{gap_s:.3g} s",
                    gap_s,
                )
            else:
                self._told.pop(f"{name} joins", None)

    def _offset(self, ref: str, who: str, monitor: SenderMonitor) -> Iterator[str]:
        """Note and yield the offset of a sender's clock from ours."""
        offset_s = monitor.offset_s
        if monitor.has_boot_time:
            self.notes[ref] = "stamps are of CLOCK_MONOTONIC, the time since boot: only stamps of that clock join them"
            yield from self._news(ref, f"{who}: {self.notes[ref]}")
            return
        if abs(offset_s) < NOTABLE_OFFSET_S:
            self._told.pop(ref, None)
            return
        note = f"its clock is {span_text(offset_s)} {side_text(offset_s)} this machine's{_reason(offset_s)}"
        if not monitor.counts_offset:
            note += ", which does not count as age"
        elif offset_s < 0:
            note += f", or it takes that long: counts as age, since it is below max_age_s ({monitor.max_age_s:.2g} s)"
        else:
            note += ": its messages look younger than they are"
        self.notes[ref] = note
        yield from self._news(ref, f"{who}: {note}", offset_s, _SYNC)

    def _apart(self, pair: _Pair) -> Iterator[str]:
        """Note and yield the offset between two inputs that a stage joins."""
        first, second = (self._schedule.intakes[ref] for ref in (pair.first, pair.second))
        if any(one.monitor.stamp_fault or one.monitor.accepted < _MIN_ACCEPTED for one in (first, second)):
            return
        offset_s = first.monitor.offset_s - second.monitor.offset_s
        key = f"{pair.stage} {pair.first} {pair.second}"
        if abs(offset_s) < NOTABLE_OFFSET_S:
            self._told.pop(key, None)
            return
        self.is_troubled = True
        fate = f"{pair.stage} cannot join them"
        if pair.is_sampled and -self._schedule.clock.run_s() < offset_s < 0:  # samples of that time have come
            fate = f"{pair.stage} joins what is that far apart, unless {first.source.name} takes that long"
        far = f"{span_text(offset_s)} {side_text(offset_s)}"
        note = f"stamps of {first.source.name} are {far} those of {second.source.name}"
        self.notes[pair.first] = f"{note}: {fate}"
        yield from self._news(key, f"{pair.first}: {note}: {fate}", offset_s, _SYNC)

    def _news(self, key: str, line: str, offset_s: float = 0.0, hint: str = "") -> Iterator[str]:
        """Yield a line unless it, or one with nearly the same offset, was told last."""
        before, before_s = self._told.get(key, ("", 0.0))
        is_near = abs(offset_s - before_s) <= max(NOTABLE_OFFSET_S, _NEWS_RATIO * abs(before_s))
        if before == line or (before and offset_s and is_near):
            return
        self._told[key] = line, offset_s
        yield f"clock: {line}{hint}"


def _pairs(graph: Graph) -> Iterator[_Pair]:
    """Yield the inputs that a stage joins by stamp, each two of them at the first stage that does."""
    origins: dict[str, frozenset[str]] = {ref: frozenset({ref}) for ref in graph.inputs}
    known: set[frozenset[str]] = set()
    for node in graph.order:
        plain, sampled = frozenset[str](), frozenset[str]()
        for i in node.inputs:
            found = origins.get(i.channel.ref, frozenset()) if i.channel is not None else frozenset[str]()
            plain |= found if i.port.is_plain else frozenset()
            sampled |= found if i.port.since else frozenset()
        pairs = [(a, b, False) for a, b in combinations(sorted(plain), 2)]
        pairs += [(a, b, True) for a in sorted(plain) for b in sorted(sampled - plain)]
        for a, b, is_sampled in pairs:
            if frozenset({a, b}) not in known:
                known.add(frozenset({a, b}))
                yield _Pair(node.name, a, b, is_sampled)
        for channel in node.outputs.values():
            origins[channel.ref] = frozenset() if node.every_ms is not None else plain


def _reason(offset_s: float) -> str:
    """Return a probable reason of an offset, empty if none is known."""
    size_s = abs(offset_s)
    if size_s > _YEAR_S:
        return " (a clock that was never set, or the time since boot of another machine)"
    halves = round(size_s / _HALF_HOUR_S)
    if 1 <= halves <= 2 * _MAX_LOCAL_H and abs(size_s - halves * _HALF_HOUR_S) < _LOCAL_TIME_S:
        return f" ({halves / 2:g} h: local time in place of UTC?)"
    return ""
