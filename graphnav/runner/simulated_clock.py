"""How fast simulated time passes; what time it is, the stamps say."""

from __future__ import annotations

import time
from collections.abc import Callable

MAX_LATE_S = 0.5
"""Behind by more than this, a paced clock gives the time up instead of making up for it, and says so."""


class SimulatedClock:
    """Jumps from stamp to stamp, as fast as the machine allows or at a pace that people can watch.

    ``pace_ratio``: simulated seconds per wall second; None does not wait at all. ``notice`` is called when the clock is
    behind by more than half a second, and again each time that has doubled.
    """

    def __init__(
        self,
        pace_ratio: float | None = None,
        wall_s: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
        notice: Callable[[str], None] = lambda _: None,
    ) -> None:
        self.behind_s = 0.0
        """Wall seconds by which the newest stamp came later than the pace asks for, since the first one; 0 unpaced."""
        self._pace_ratio = pace_ratio
        self._wall_s, self._sleep, self._notice = wall_s, sleep, notice
        self._offset_s: float | None = None
        self._given_up_s = 0.0
        self._noticed_s = MAX_LATE_S / 2
        self._ticks = Ticks()

    def advance(self, utime: int) -> None:
        """Let it be ``utime``, after the wait that the pace asks for; the first stamp comes at once."""
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
    """What ticks take and what the pace gives them, on average."""

    def __init__(self) -> None:
        self._count = 0
        self._took_s = self._due_s = 0.0
        self._began: tuple[float, float] | None = None

    def begin(self, wall_s: float, due_s: float) -> None:
        """Note when a tick begins and when it was due."""
        self._began = wall_s, due_s

    def end(self, wall_s: float, due_s: float) -> None:
        """Note when the tick that began has ended and when the next one is due."""
        if self._began is not None:
            self._count += 1
            self._took_s += wall_s - self._began[0]
            self._due_s += due_s - self._began[1]

    def __str__(self) -> str:
        count = max(1, self._count)
        took = f"a tick takes {_ms(self._took_s / count)} ms, the pace asks for {_ms(self._due_s / count)} ms"
        return took if self._took_s > self._due_s else f"the process was held up ({took})"


def _ms(duration_s: float) -> str:
    """Return milliseconds with two digits at least: 0.25, 9.5, 19."""
    duration_ms = duration_s * 1e3
    return f"{duration_ms:.0f}" if duration_ms >= 10 else f"{duration_ms:.2g}"
