"""The clock of another host beside this machine's, from questions and answers over a connection, as NTP has it.

All is measured against this machine's time since its boot (`boot_ns`), which nothing sets and which goes on while the
machine is suspended. So a clock there that is set changes what is measured, and a clock here that is set does not:
`OwnClock` notices that one, by the same time since boot.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from itertools import combinations
from statistics import median
from typing import NamedTuple

_MIN_STEP_NS = 5_000_000
"""A smaller change is not told."""
_MAX_DRIFT = 1e-3
"""Two kernels that correct their clocks as fast as NTP does, each by 500 ppm: what goes beyond is a step."""
_WANDER = 1e-4
"""By which an answer gets worse with its age: clocks of computers drift by less."""
_N_RECENT = 64
_SPAN_NS = 10_000_000_000
"""The drift is that of the best answers of such spans, the newest five minutes of them."""
_MIN_SPANS, _MAX_SPANS = 6, 30
_SPREAD = 2e-5
"""The drift counts as known if half of the slopes that it is the median of are as near to it."""
_GAP_NS, _TRIES = 100_000, 3


class Reading(NamedTuple):
    """Clocks of this machine at one moment: time since its boot, time of day, and how far apart they may be read."""

    boot_ns: int
    wall_ns: int
    error_ns: float = 0.0


def boot_ns() -> int:
    """Return the time since this machine's boot."""
    return time.clock_gettime_ns(time.CLOCK_BOOTTIME)


def read_clocks(wall_ns: Callable[[], int] = time.time_ns) -> Reading:
    """Return this machine's clocks; tries again where the process is interrupted between them."""
    readings = []
    for _ in range(_TRIES):
        begin_ns, now_ns, end_ns = boot_ns(), wall_ns(), boot_ns()
        readings.append(Reading((begin_ns + end_ns) // 2, now_ns, (end_ns - begin_ns) / 2))
        if end_ns - begin_ns <= _GAP_NS:
            break
    return min(readings, key=lambda one: one.error_ns)


class OwnClock:
    """Notices that this machine's clock was set."""

    def __init__(self) -> None:
        self._last: Reading | None = None

    def look(self, now: Reading) -> float:
        """Return by how much it was set since the last call, seconds; 0 if it was not."""
        last, self._last = self._last, now
        if last is None:
            return 0.0
        change_ns = (now.wall_ns - now.boot_ns) - (last.wall_ns - last.boot_ns)
        is_step = abs(change_ns) > max(_MIN_STEP_NS, now.error_ns + last.error_ns)
        return change_ns * 1e-9 if is_step else 0.0


class ClockState(NamedTuple):
    """The clock of another host: how far it is ahead of this machine's, give or take ``error_s``.

    ``round_trip_s``: of the answer that tells the offset. ``drift_ppm``: how much faster it goes, None while that is
    not known. ``n_steps``: how often it was set since the connection was made; ``step_s``: last, by how much.
    """

    round_trip_s: float
    offset_s: float
    error_s: float
    drift_ppm: float | None
    n_steps: int
    step_s: float


class _Sample(NamedTuple):
    """An answer: when it was made, by this machine's time since boot, and how far the clock there is ahead of that."""

    at_ns: int
    ahead_ns: int
    error_ns: float


class HostClock:
    """Estimates the clock of another host.

    The offset is that of the answer with the shortest round trip among the last ones, each a little worse with its
    age; it cannot be wrong by more than half of that round trip, however much longer one way takes than the other. A
    later answer that contradicts it beyond both errors and any drift is a step, after which all begins again.
    ``n_answers``: those that count.
    """

    def __init__(self) -> None:
        self.n_answers = self.n_steps = 0
        self.step_s = 0.0
        """The last step; positive where the clock was set ahead."""
        self._recent: deque[_Sample] = deque(maxlen=_N_RECENT)
        self._spans: deque[_Sample] = deque(maxlen=_MAX_SPANS + 1)
        """The best of each span; the last one has not ended."""
        self._span_begin_ns = 0
        self._drift: float | None = None

    def add(self, asked_ns: int, heard_ns: int, held_ns: int, wall_ns: int) -> None:
        """Take an answer.

        ``asked_ns``, ``heard_ns``: when the question was sent and the answer came, by this machine's time since boot.
        ``held_ns``: how long the other host had the question. ``wall_ns``: its time of day when it answered.
        """
        round_trip_ns = heard_ns - asked_ns - held_ns
        if round_trip_ns < 0:  # it was held for so long that the drift counts, or what it says is wrong
            return
        self.n_answers += 1
        at_ns = heard_ns - round_trip_ns // 2
        sample = _Sample(at_ns, wall_ns - at_ns, round_trip_ns / 2)
        if self._recent:
            self._note_step(sample)
        self._recent.append(sample)
        self._note_span(sample)

    def state(self, now: Reading) -> ClockState | None:
        """Return the clock at a moment, None before the first answer."""
        if not self._recent:
            return None
        best = self._best(now.boot_ns)
        age_ns = now.boot_ns - best.at_ns
        offset_ns = self._expected_ns(best, now.boot_ns) - (now.wall_ns - now.boot_ns)
        return ClockState(
            round_trip_s=2e-9 * best.error_ns,
            offset_s=1e-9 * offset_ns,
            error_s=1e-9 * (best.error_ns + now.error_ns + _WANDER * age_ns),
            drift_ppm=None if self._drift is None else 1e6 * self._drift,
            n_steps=self.n_steps,
            step_s=self.step_s,
        )

    def _best(self, at_ns: int) -> _Sample:
        return min(self._recent, key=lambda one: one.error_ns + _WANDER * (at_ns - one.at_ns))

    def _expected_ns(self, best: _Sample, at_ns: int) -> int:
        """Return how far the clock there is ahead of the time since boot, at another moment."""
        return best.ahead_ns + round((self._drift or 0.0) * (at_ns - best.at_ns))

    def _note_step(self, sample: _Sample) -> None:
        best = self._best(sample.at_ns)
        change_ns = sample.ahead_ns - self._expected_ns(best, sample.at_ns)
        allowed_ns = best.error_ns + sample.error_ns + _MAX_DRIFT * (sample.at_ns - best.at_ns)
        if abs(change_ns) > max(_MIN_STEP_NS, allowed_ns):
            self.n_steps += 1
            self.step_s = change_ns * 1e-9
            self._recent.clear()
            self._spans.clear()
            self._drift = None

    def _note_span(self, sample: _Sample) -> None:
        if not self._spans or sample.at_ns - self._span_begin_ns >= _SPAN_NS:
            self._drift = _slope(tuple(self._spans))
            self._span_begin_ns = sample.at_ns
            self._spans.append(sample)
        elif sample.error_ns < self._spans[-1].error_ns:
            self._spans[-1] = sample


def _slope(samples: tuple[_Sample, ...]) -> float | None:
    """Return the median slope of pairs that are half of all apart (Theil and Sen), None if there is not enough."""
    if len(samples) < _MIN_SPANS:
        return None
    pairs = [(samples[i], samples[k]) for i, k in combinations(range(len(samples)), 2) if 2 * (k - i) >= len(samples)]
    slopes = [(b.ahead_ns - a.ahead_ns) / (b.at_ns - a.at_ns) for a, b in pairs]
    middle = median(slopes)
    return middle if median(abs(one - middle) for one in slopes) <= _SPREAD else None
