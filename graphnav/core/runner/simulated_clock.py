"""The pace of simulated time; the time itself is that of the messages' timestamps."""

from __future__ import annotations

import time
from collections.abc import Callable

MAX_LATE_S = 0.5
"""A paced clock that is later than this shifts its schedule instead of catching up, with a notice."""


class SimulatedClock:
    """A clock that advances from timestamp to timestamp, unpaced or at a multiple of wall time.

    ``pace_ratio``: simulated seconds per wall second; None never waits. ``notice`` is called when the clock is more
    than half a second late, and again each time the delay has doubled.
    """

    def __init__(
        self,
        pace_ratio: float | None = None,
        wall_s: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        notice: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.behind_s = 0.0
        """Wall seconds by which the newest timestamp is behind the pace; 0 without a pace."""
        self._pace_ratio = pace_ratio
        self._wall_s, self._sleep, self._notice = wall_s, sleep, notice
        self._offset_s: float | None = None
        self._given_up_s = 0.0
        self._noticed_s = MAX_LATE_S / 2
        self._ticks = Ticks()

    def advance(self, utime: int) -> None:
        """Advance to ``utime`` after the wait required by the pace; the first timestamp needs no wait."""
        if self._pace_ratio is None:
            return
        due_s = utime / 1e6 / self._pace_ratio
        wall_s = self._wall_s()
        if self._offset_s is None:
            self._offset_s = wall_s - due_s
        self._ticks.end(wall_s, due_s)
        late_s = wall_s - self._offset_s - due_s
        self.behind_s = self._given_up_s + max(0.0, late_s)
        if late_s > MAX_LATE_S:
            self._offset_s += late_s
            self._given_up_s += late_s
        elif late_s < 0:
            self._sleep(-late_s)
        if self.behind_s > MAX_LATE_S and self.behind_s >= 2 * self._noticed_s:
            self._noticed_s = self.behind_s
            self._notice(f"behind the wall clock by {self.behind_s:.1f} s: {self._ticks}")
            self._ticks = Ticks()
        self._ticks.begin(self._wall_s(), due_s)


class Ticks:
    """Average duration of ticks, and the average available time."""

    def __init__(self) -> None:
        self._count = 0
        self._took_s = self._due_s = 0.0
        self._began: tuple[float, float] | None = None

    def begin(self, wall_s: float, due_s: float) -> None:
        """Record when a tick begins and when it was due."""
        self._began = wall_s, due_s

    def end(self, wall_s: float, due_s: float) -> None:
        """Record when the tick ended and when the next one is due."""
        if self._began is not None:
            self._count += 1
            self._took_s += wall_s - self._began[0]
            self._due_s += due_s - self._began[1]

    def __str__(self) -> str:
        count = max(1, self._count)
        took = f"a tick takes {_ms(self._took_s / count)} ms, the pace allows {_ms(self._due_s / count)} ms"
        return took if self._took_s > self._due_s else f"the process was held up ({took})"


def _ms(duration_s: float) -> str:
    """Format milliseconds with at least two digits: 0.25, 9.5, 19."""
    duration_ms = duration_s * 1e3
    return f"{duration_ms:.0f}" if duration_ms >= 10 else f"{duration_ms:.2g}"
