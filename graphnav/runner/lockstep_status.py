"""Publish the status of a lockstep run for viewers: `graphnav.status`, once a second of wall time."""

from __future__ import annotations

import time
from collections.abc import Callable

from graphnav.codec import encode
from graphnav.messages import Status
from graphnav.runner.lockstep import Runner
from graphnav.runner.owned_stages import Sink
from graphnav.runner.stage_health import Rates, memory_mb, stage_statuses

STATUS = "graphnav.status"
"""The channel on which a run publishes its status once a second."""
_PERIOD_S = 1.0


class LockstepStatus:
    """Writes a status to the tap once a second; never to the log, which contains no wall-clock measurements."""

    def __init__(self, runner: Runner, tap: Sink, run_id: str, dropped: Callable[[], int]) -> None:
        self._runner, self._tap, self._run_id, self._dropped = runner, tap, run_id, dropped
        self._start_s = self._last_s = time.monotonic()
        self._rates = Rates()
        self._count = 0

    def before_tick(self, utime: int, behind_s: float) -> None:
        """Publish a status if the last one is a second old."""
        now_s = time.monotonic()
        elapsed_s = now_s - self._last_s
        if elapsed_s < _PERIOD_S:
            return
        self._last_s = now_s
        status = Status(
            run_id=self._run_id,
            graph=self._runner.graph.path.stem,
            live=False,
            wall_s=now_s - self._start_s,
            run_s=utime / 1e6,
            behind_s=behind_s,
            memory_mb=memory_mb(),
            tap_dropped=self._dropped(),
            log_dropped=0,
            log_fault="",
            stages=stage_statuses(self._runner.units, self._rates, elapsed_s),
            inputs=(),
            outputs=(),
            edges=(),
        )
        self._tap.write(STATUS, utime, encode(status, utime, self._count))
        self._count += 1
