"""Detect a hanging step from a separate thread."""

from __future__ import annotations

import threading
from collections.abc import Callable

from graphnav.live.live_schedule import LiveSchedule

_PERIOD_S = 0.5
_HANGS_S = 1.0


class Watchdog:
    """Reports through ``notice``, once per step, a stage that has been in one step for more than a second.

    A native call that holds Python's interpreter lock blocks it too: then only the motor process acts.
    """

    def __init__(self, schedule: LiveSchedule, notice: Callable[[str], None]) -> None:
        self._schedule, self._notice = schedule, notice
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="graphnav-watchdog", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop watching."""
        self._ending.set()
        self._thread.join()

    def _serve(self) -> None:
        told: tuple[str, float] | None = None
        while not self._ending.wait(_PERIOD_S):
            step = self._schedule.step_began
            if step is not None and step != told and self._schedule.clock.now_s() - step[1] > _HANGS_S:
                told = step
                hung_s = self._schedule.clock.now_s() - step[1]
                self._notice(f"hangs: {step[0]} has been in one step for {hung_s:.1f} s; motor channels get stops")
