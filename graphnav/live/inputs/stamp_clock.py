"""Recognize the unit and the clock of a sender's stamps, for a diagnosis in place of its symptoms."""

from __future__ import annotations

from typing import NamedTuple

_AGREEING = 3
"""Consecutive messages that have to look the same: one stamp may be damaged."""
_WALL_RATIO = 0.8, 1.25
"""Stamps of the time of day, in its unit, differ by at most this from ours: 11 years."""
_BOOT_S = 5.0
"""Stamps of this machine's CLOCK_MONOTONIC differ from it by at most this."""
_WINDOW_S = 2.0
_MIN_IN_WINDOW = 5
_MIN_RATE, _MAX_RATE = 0.6, 1.6
"""Stamps in microseconds that advance less or more than this between arrivals are not of a clock."""
_STILL = "utime does not advance: the sender repeats its last message, or sets no stamp"


class _Unit(NamedTuple):
    """A unit of time: its name, microseconds in one, and how its stamps become microseconds."""

    name: str
    us: float
    factor: str


_US = _Unit("microseconds", 1.0, "")
_UNITS = (
    _Unit("seconds", 1e6, "multiply by 1000000"),
    _Unit("milliseconds", 1e3, "multiply by 1000"),
    _US,
    _Unit("nanoseconds", 1e-3, "divide by 1000"),
)


class _Advance(NamedTuple):
    """Finding about the advance of the stamps within a time: the fault, the unit, and whether they advance too fast."""

    fault: str = ""
    unit: _Unit | None = None
    is_fast: bool | None = None


class StampClock:
    """Unit and clock of one sender's stamps, by their values and by how much they advance between arrivals.

    ``fault`` says what is wrong with them, empty if they are in microseconds and advance. ``is_boot_time``: whether
    they are of this machine's CLOCK_MONOTONIC, in whatever unit. Both are known after 3 messages if the values tell,
    else after 4 s.
    """

    def __init__(self) -> None:
        self.fault = ""
        self.is_boot_time = False
        self._last: tuple[str, bool] = "", False
        self._agreeing = 0
        self._begin: tuple[int, float] | None = None
        self._in_window = 0
        self._still: tuple[int, float] | None = None
        self._is_still = False
        self._by_window = _Advance()
        self._advancing = ""

    def add(self, stamp: int, arrival_s: float, arrival_utime: int) -> None:
        """Add the stamp of a message that arrived at ``arrival_s`` (monotonic), ``arrival_utime`` by our clock."""
        self._add_to_window(stamp, arrival_s)
        if self._still is None or stamp != self._still[0]:
            self._still = stamp, arrival_s
        self._is_still = arrival_s - self._still[1] >= _WINDOW_S
        seen = _by_value(stamp, arrival_s, arrival_utime)
        self._agreeing = self._agreeing + 1 if seen == self._last else 1
        self._last = seen
        if self._agreeing >= _AGREEING:
            by_value, self.is_boot_time = seen
            self.fault = by_value or (_STILL if self._is_still else self._advancing)

    def _add_to_window(self, stamp: int, arrival_s: float) -> None:
        """Compare the advance of the stamps with that of the arrivals over at least 2 s and 5 messages."""
        if self._begin is None:
            self._begin = stamp, arrival_s
            return
        self._in_window += 1
        begin, begin_s = self._begin
        elapsed_s = arrival_s - begin_s
        if elapsed_s < _WINDOW_S or self._in_window < _MIN_IN_WINDOW:
            return
        before, self._by_window = self._by_window, _by_advance(stamp - begin, elapsed_s)
        is_lasting = self._by_window.unit == before.unit and self._by_window.is_fast == before.is_fast
        self._advancing = self._by_window.fault if is_lasting else ""  # a clock that jumps looks so once
        self._begin, self._in_window = (stamp, arrival_s), 0


def _by_value(stamp: int, arrival_s: float, arrival_utime: int) -> tuple[str, bool]:
    """Return the fault that the value of a stamp tells, and whether it is of this machine's CLOCK_MONOTONIC."""
    if stamp == 0:
        return "utime is 0: the sender sets no stamp", False
    low, high = _WALL_RATIO
    for (
        unit
    ) in _UNITS:  # first: for half an hour after boot, its microseconds are as many as seconds of the time of day
        if abs(stamp * unit.us * 1e-6 - arrival_s) < _BOOT_S < arrival_s:
            return _unit_fault(unit, " of CLOCK_MONOTONIC"), True
    for unit in _UNITS:
        if low < stamp * unit.us / arrival_utime < high:
            return _unit_fault(unit), False
    return "", False


def _by_advance(advance: int, elapsed_s: float) -> _Advance:
    """Return what the advance of the stamps within a time tells."""
    for unit in _UNITS:
        rate = advance * unit.us * 1e-6 / elapsed_s
        if 1 / 3 < rate < 3:
            if unit is _US and not _MIN_RATE < rate < _MAX_RATE:
                what = "utime is the time of the data, not a count of frames at a nominal rate"
                return _Advance(f"utime advances by {rate:.2f} s a second: {what}", unit, rate > 1)
            return _Advance(_unit_fault(unit), unit)
    return _Advance()


def _unit_fault(unit: _Unit, of: str = "") -> str:
    return "" if unit is _US else f"stamps look like {unit.name}{of}: utime is in microseconds, {unit.factor}"
