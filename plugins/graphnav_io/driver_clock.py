"""When a picture was taken, by the stamps of a camera's driver."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

MAX_DELAY_S = 2.0
"""A driver's first stamp that is further in the past is of another clock."""
MAX_AHEAD_S = 0.005
"""Stamps are rounded, and the time of arrival is read after the picture has come."""
MIN_STEP_S = 2e-6
"""Between two pictures: stamps are microseconds."""
ARRIVAL, MONOTONIC, WALL = "the time of arrival", "the driver", "the driver, by the time of day"


class DriverClock:
    """Turns the stamps of a driver, seconds, into seconds of `time.monotonic`, each later than the one before.

    V4L2 stamps the buffer of a picture by the monotonic clock when it is filled, some drivers by the time of day. A
    stamp that neither clock could have given counts as missing: then it is the time of arrival, which is later than the
    picture by what exposure, transfer and driver took. A picture that waited for long in a buffer, because this process
    was suspended, is as old as its stamp.
    """

    def __init__(self, wall_s: Callable[[], float] = time.time) -> None:
        self.kind = ""
        """In words, by which clock the newest picture was stamped; empty before the first one."""
        self._wall_s = wall_s
        self._last_s = -math.inf
        self._driver_s = math.nan

    def begin(self) -> None:
        """Forget which clock it was: the device is another one, perhaps."""
        self.kind = ""

    def is_repeated(self, driver_s: float) -> bool:
        """Whether a picture has the stamp of the one before: the same buffer again, and not a new picture."""
        return driver_s > 0.0 and driver_s == self._driver_s

    def taken_s(self, driver_s: float, arrived_s: float) -> float:
        """Return when a picture was taken that arrived at ``arrived_s``; ``driver_s``: the driver's stamp, 0: none."""
        self._driver_s = driver_s
        oldest_s = math.inf if self.kind == MONOTONIC else MAX_DELAY_S
        taken_s, self.kind = arrived_s, ARRIVAL
        if driver_s > 0.0 and -MAX_AHEAD_S <= arrived_s - driver_s <= oldest_s:
            taken_s, self.kind = min(driver_s, arrived_s), MONOTONIC
        elif driver_s > 0.0 and -MAX_AHEAD_S <= (delay_s := self._wall_s() - driver_s) <= MAX_DELAY_S:
            taken_s, self.kind = arrived_s - max(0.0, delay_s), WALL
        self._last_s = max(taken_s, self._last_s + MIN_STEP_S)
        return self._last_s
