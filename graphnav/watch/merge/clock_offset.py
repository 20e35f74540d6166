"""Measure by how much one log's clock is ahead of another one's, from messages that both logs hold.

A message that A sent is logged by B after its way, and so bounds the offset of B's clock from above; one that B sent
bounds it from below, as in NTP. Between the two bounds lies a line, whose slope is the drift. Where no line does, the
clock was set, or changed its rate, and another line begins.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from graphnav import GraphnavError

Ints = NDArray[np.int64]
Floats = NDArray[np.float64]

MAX_DRIFT = 5e-4
"""The rate that NTP slews a clock by, and more than that of any two oscillators."""
_TOLERANCE_US = 1000.0
"""Bounds may contradict by this much: a busy sender logs a message late."""
_ONE_WAY_TOLERANCE_US = 100_000.0
"""Without messages of the other direction, a shortest delay that changes by more is a clock that was set."""
_DRIFT_SPAN_US = 60e6
"""The span that the drift needs without messages of both directions."""
_MIN_WINDOW, _MAX_WINDOWS = 8, 2000
_SET_GAP_RATIO = 5.0
"""A longest gap that is so much longer than the others is where the clock was set."""
_LOOK_AHEAD = 40
_MAX_STRETCHES = 100
_NEAR_US = 1e6
_MAX_DRIFT_ERROR = 5e-5
"""A drift that is known less well than this is taken as 0, which two clocks are nearer to."""


class SharedMessages(NamedTuple):
    """Messages that both logs hold, in the order of the other log.

    ``numbers``: which events they are there. ``at_us``: when it logged them, ``ahead_us``: by how much later than the
    first log. ``ways``: 1 from the first log's host to the other's, -1 back, 0 where that is not known.
    """

    numbers: Ints
    at_us: Ints
    ahead_us: Ints
    ways: Ints


class Stretch(NamedTuple):
    """A line: ``ahead_us`` at ``origin_us`` of the other log's clock, and the drift, from an event on."""

    number: int
    origin_us: int
    ahead_us: float
    drift: float

    def ahead_at(self, at_us: int) -> float:
        """Return the offset at a time of the other log's clock."""
        return self.ahead_us + self.drift * (at_us - self.origin_us)


class Set(NamedTuple):
    """A clock that was set: when, by the other log's clock before it, and by how much it went ahead of the first."""

    at_us: int
    by_us: int


class ClockOffset(NamedTuple):
    """By how much a log's clock is ahead of the first log's.

    ``error_us``: half the room between the bounds, None where messages of one direction only, or of unknown direction,
    bound it up to a delay; 0 if it was given by hand. ``drift``: of the longest line, ``drift_error`` of it; None where
    one direction alone does not tell.
    ``n_there``, ``n_back``, ``n_unknown``: the messages by direction.
    """

    stretches: tuple[Stretch, ...]
    error_us: float | None
    drift: float = 0.0
    drift_error: float | None = None
    sets: tuple[Set, ...] = ()
    n_there: int = 0
    n_back: int = 0
    n_unknown: int = 0

    @staticmethod
    def given(ahead_us: int) -> ClockOffset:
        """Return an offset that is known."""
        return ClockOffset((Stretch(0, 0, ahead_us, 0.0),), 0.0)

    def to_first(self, at_us: Ints) -> Ints:
        """Return the times of all events of the log by the first log's clock."""
        found = at_us.copy()
        ends = [*(one.number for one in self.stretches[1:]), len(at_us)]
        for stretch, end in zip(self.stretches, ends, strict=True):
            part = slice(0 if stretch is self.stretches[0] else stretch.number, end)
            drifted = np.rint(stretch.drift * (at_us[part] - stretch.origin_us)).astype(np.int64)
            found[part] -= drifted + round(stretch.ahead_us)
        return found


class _Points(NamedTuple):
    """Bounds of the offset: which events they are of, when, and how large."""

    numbers: Ints
    at_us: Floats
    ahead_us: Floats

    def part(self, begin: int, end: int) -> _Points:
        """Return those of the events from one number to before another."""
        return self.chosen((self.numbers >= begin) & (self.numbers < end))

    def chosen(self, kept: NDArray[np.bool_]) -> _Points:
        """Return those of a mask."""
        return _Points(self.numbers[kept], self.at_us[kept], self.ahead_us[kept])

    def highest_near(self, at_us: Floats) -> Floats:
        """Return the largest of those within a second of each time, -inf where there are none."""
        begins = np.searchsorted(self.at_us, at_us - _NEAR_US)
        ends = np.searchsorted(self.at_us, at_us + _NEAR_US, "right")
        return np.array(
            [self.ahead_us[begin:end].max(initial=-np.inf) for begin, end in zip(begins, ends, strict=True)]
        )


class _Bounds(NamedTuple):
    """An upper and a lower bound of the offset; ``tolerance_us``: by how much they may contradict."""

    upper: _Points
    lower: _Points
    tolerance_us: float

    def part(self, begin: int, end: int) -> _Bounds:
        """Return those of the events from one number to before another."""
        return _Bounds(self.upper.part(begin, end), self.lower.part(begin, end), self.tolerance_us)

    def room_us(self, slopes: Floats) -> Floats:
        """Return the room between the bounds along lines of some slopes, infinite where there is one bound alone."""
        return self._above(slopes) - self._below(slopes)

    def middle_us(self, slope: float) -> float:
        """Return the offset at time 0 of the line in the middle."""
        above, below = self._above(np.array([slope]))[0], self._below(np.array([slope]))[0]
        if np.isinf(above) or np.isinf(below):
            return float(below if np.isinf(above) else above)
        return float(above + below) / 2

    def limits_us(self, slopes: Floats, at_us: float) -> tuple[float, float]:
        """Return the lowest and the highest offset at a time, of all lines of some slopes between the bounds."""
        below, above = self._below(slopes) + slopes * at_us, self._above(slopes) + slopes * at_us
        return float(min(below.min(), above.min())), float(max(below.max(), above.max()))

    def is_possible(self) -> bool:
        """Whether a line lies between the bounds."""
        return bool(self.room_us(np.array([self.slope()]))[0] >= -2 * self.tolerance_us)

    def slope(self) -> float:
        """Return the slope of the line with the most room; of several the one nearest to 0."""
        low, high = -MAX_DRIFT, MAX_DRIFT
        for _ in range(5):
            slopes = np.linspace(low, high, 41)
            room_us = self.room_us(slopes)
            if np.isinf(room_us).all():
                return 0.0
            best = slopes[np.argmax(room_us)]
            step = slopes[1] - slopes[0]
            low, high = max(-MAX_DRIFT, best - step), min(MAX_DRIFT, best + step)
        return 0.0 if self.room_us(np.zeros(1))[0] >= room_us.max() - 1.0 else float(best)

    def slopes(self, best: float) -> tuple[float, float]:
        """Return the smallest and the largest slope of lines between the bounds."""
        room_us = float(self.room_us(np.array([best]))[0])
        needed_us = 0.0 if room_us >= 0 else room_us - self.tolerance_us
        ends = []
        for end in (-MAX_DRIFT, MAX_DRIFT):
            inside, outside = best, end
            if self.room_us(np.array([end]))[0] >= needed_us:
                inside = end
            for _ in range(40):
                middle = (inside + outside) / 2
                if self.room_us(np.array([middle]))[0] >= needed_us:
                    inside = middle
                else:
                    outside = middle
            ends.append(inside)
        return ends[0], ends[1]

    def _above(self, slopes: Floats) -> Floats:
        return _lowest(self.upper, slopes)

    def _below(self, slopes: Floats) -> Floats:
        return -_lowest(self.lower._replace(ahead_us=-self.lower.ahead_us), -slopes)


def _lowest(points: _Points, slopes: Floats) -> Floats:
    if not points.numbers.size:
        return np.full(slopes.shape, np.inf)
    above: Floats = (points.ahead_us[:, None] - points.at_us[:, None] * slopes).min(axis=0)
    return above


def measure(shared: SharedMessages, at_us: Ints) -> ClockOffset:
    """Return the offset of a log whose events have the times ``at_us``, from at least one shared message.

    Raises
    ------
    GraphnavError
        The messages fit no clock, even one that is set now and then.
    """
    there, back = shared.ways > 0, shared.ways < 0
    n_there, n_back = int(there.sum()), int(back.sum())
    is_bounded = bool(n_there and n_back)
    origin_us = int(shared.at_us[0])
    points = _Points(shared.numbers, (shared.at_us - origin_us).astype(np.float64), shared.ahead_us.astype(np.float64))
    parts = _parts_of_all(_bounds(points, there, back), at_us)
    ends = [*(begin for begin, _ in parts[1:]), len(at_us)]
    longest = max(range(len(parts)), key=lambda place: ends[place] - parts[place][0])
    error_us, drift_error = None, None
    if is_bounded:
        lines = [_between(part) for _, part in parts]
        error_us = max(
            _error_us(part, line, (at_us[begin] - origin_us, at_us[end - 1] - origin_us))
            for (begin, part), line, end in zip(parts, lines, ends, strict=True)
        )
        drift = lines[longest][1]
        drift_error = max(abs(end - drift) for end in parts[longest][1].slopes(drift))
    else:
        lines = [_beside(part.upper, 1 if n_there else -1 if n_back else 0) for _, part in parts]
    stretches = [
        Stretch(begin, origin_us, ahead_us, drift) for (begin, _), (ahead_us, drift) in zip(parts, lines, strict=True)
    ]
    noticed_us = _ONE_WAY_TOLERANCE_US / 2 if error_us is None else 2 * error_us + _TOLERANCE_US
    sets = [one for one in _sets(stretches, at_us) if abs(one.by_us) > noticed_us]
    n_unknown = 0 if n_there or n_back else len(shared.ways)
    return ClockOffset(
        tuple(stretches), error_us, lines[longest][1], drift_error, tuple(sets), n_there, n_back, n_unknown
    )


def _bounds(points: _Points, there: NDArray[np.bool_], back: NDArray[np.bool_]) -> _Bounds:
    """Return the bounds by messages of both directions; else the messages themselves as both, with a wide tolerance."""
    if there.any() and back.any():
        return _Bounds(_thinned(points, there, 0.1), _thinned(points, back, 0.9), _TOLERANCE_US)
    if there.any() or back.any():
        near = _thinned(points, there | back, 0.1 if there.any() else 0.9)
    else:
        near = _thinned(points, np.ones(len(points.numbers), np.bool_), 0.5)
    return _Bounds(near, near, _ONE_WAY_TOLERANCE_US / 2)


def _parts_of_all(bounds: _Bounds, at_us: Ints) -> list[tuple[int, _Bounds]]:
    """Return the parts that one line each lies in, without outliers where these alone make several."""
    parts = _parts(bounds, at_us)
    if len(parts) == 1:
        return parts
    without = _parts(_consistent(bounds), at_us)
    return without if len(without) < len(parts) else parts


def _sets(stretches: Sequence[Stretch], at_us: Ints) -> Iterator[Set]:
    """Yield the steps between stretches."""
    for before, after in pairwise(stretches):
        at = int(at_us[max(0, after.number - 1)])
        yield Set(at, round(after.ahead_at(int(at_us[after.number])) - before.ahead_at(at)))


def _thinned(points: _Points, chosen: NDArray[np.bool_], quantile: float) -> _Points:
    """Return one point of each window of consecutive ones: the one at a quantile, so that few outliers count nothing.

    It is less tight than the lowest, and so on the safe side.
    """
    points = points.chosen(chosen)
    n_points = len(points.numbers)
    if n_points < 2 * _MIN_WINDOW:
        return points
    windows = np.array_split(np.arange(n_points), min(n_points // _MIN_WINDOW, _MAX_WINDOWS))
    picked = [
        window[np.argsort(points.ahead_us[window], kind="stable")[round(quantile * (len(window) - 1))]]
        for window in windows
    ]
    return points.chosen(np.isin(np.arange(n_points), picked))


def _consistent(bounds: _Bounds) -> _Bounds:
    """Return the bounds without those that contradict another one nearby: a busy host logs what it sends late."""
    upper, lower, tolerance_us = bounds
    highest = lower.highest_near(upper.at_us)
    lowest = -upper._replace(ahead_us=-upper.ahead_us).highest_near(lower.at_us)
    kept_upper = upper.chosen(highest - upper.ahead_us <= 2 * tolerance_us)
    kept_lower = lower.chosen(lower.ahead_us - lowest <= 2 * tolerance_us)
    return _Bounds(kept_upper, kept_lower, tolerance_us)


def _parts(bounds: _Bounds, at_us: Ints) -> list[tuple[int, _Bounds]]:
    """Return the bounds of each stretch that a line lies in, as long as it can be, with the event that it begins at."""
    numbers = np.unique(np.concatenate([bounds.upper.numbers, bounds.lower.numbers]))
    parts: list[tuple[int, _Bounds]] = []
    begin = 0
    while True:
        rest = bounds.part(begin, len(at_us))
        if rest.is_possible():
            return [*parts, (begin, rest)]
        within = numbers[numbers >= begin]
        n_fit, n_over = 1, len(within)
        while n_over - n_fit > 1:
            n = (n_fit + n_over) // 2
            if bounds.part(begin, within[n - 1] + 1).is_possible():
                n_fit = n
            else:
                n_over = n
        end = _begin_of_next(bounds, within, n_fit, at_us)
        parts.append((begin, bounds.part(begin, end)))
        if len(parts) >= _MAX_STRETCHES:
            raise GraphnavError("the times of the messages that both hold fit no clock")
        begin = end


def _begin_of_next(bounds: _Bounds, within: Ints, n_fit: int, at_us: Ints) -> int:
    """Return the first event after a clock was set, where ``within[n_fit]`` is the first that contradicts.

    The events between the last one of before, which contradicts those that follow, and that one may belong to either:
    the log's own clock makes a jump there, unless it is the other one that was set.
    """
    ahead = int(within[min(n_fit + _LOOK_AHEAD, len(within) - 1)]) + 1
    low, high = 0, n_fit
    while high - low > 1:
        middle = (low + high) // 2
        if bounds.part(int(within[middle]), ahead).is_possible():
            high = middle
        else:
            low = middle
    first, last = int(within[low]), int(within[n_fit])
    gaps_us = np.abs(np.diff(at_us[first : last + 1]))
    place = int(np.argmax(gaps_us))
    if gaps_us[place] > _SET_GAP_RATIO * np.median(gaps_us):
        return first + place + 1
    return last


def _between(bounds: _Bounds) -> tuple[float, float]:
    """Return the line in the middle between two bounds: offset at time 0, and slope."""
    slope = bounds.slope()
    low, high = bounds.slopes(slope)
    if low <= 0.0 <= high and high - low > 2 * _MAX_DRIFT_ERROR:
        slope = 0.0
    return bounds.middle_us(slope), slope


def _error_us(bounds: _Bounds, line: tuple[float, float], ends_us: tuple[int, int]) -> float:
    """Return how far any line between the bounds is from this one, at the ends of its stretch."""
    ahead_us, slope = line
    slopes = np.linspace(*bounds.slopes(slope), 41)
    errors = [0.0]
    for at_us in ends_us:
        low, high = bounds.limits_us(slopes, at_us)
        here = ahead_us + slope * at_us
        errors += [value for value in (here - low, high - here) if np.isfinite(value)]
    return max(errors)


def _beside(points: _Points, side: int) -> tuple[float, float]:
    """Return the line that touches points from below (side 1) or above (-1), or that is in their middle (0)."""
    slope = 0.0
    if np.ptp(points.at_us) >= _DRIFT_SPAN_US and len(points.at_us) > 2:
        slope = _edge_slope(points, side) if side else float(np.polyfit(points.at_us, points.ahead_us, 1)[0])
        slope = min(max(slope, -MAX_DRIFT), MAX_DRIFT)
    rest_us = points.ahead_us - slope * points.at_us
    if not side:
        return float(np.median(rest_us)), slope
    return float(rest_us.min() if side > 0 else rest_us.max()), slope


def _edge_slope(points: _Points, side: int) -> float:
    """Return the slope of the line that is nearest to all points and on one side of them."""
    low, high, mean_us = -MAX_DRIFT, MAX_DRIFT, float(points.at_us.mean())
    near = points._replace(ahead_us=side * points.ahead_us)
    for _ in range(5):
        slopes = np.linspace(low, high, 41)
        best = slopes[np.argmax(_lowest(near, slopes) + slopes * mean_us)]
        step = slopes[1] - slopes[0]
        low, high = max(-MAX_DRIFT, best - step), min(MAX_DRIFT, best + step)
    return side * float(best)
