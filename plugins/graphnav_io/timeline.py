"""The times of the frames of a sequence."""

from __future__ import annotations

import numpy as np

from graphnav.arrays import Longs

ONE_PICTURE_HZ = 10.0
"""The rate of a sequence of one picture."""


class Timeline:
    """Times of frames in microseconds: recorded ones, or those of a constant rate.

    ``utimes``: int64 (n,), increasing, None for a constant ``rate_hz`` from ``start_us`` on.
    """

    def __init__(self, utimes: Longs | None, rate_hz: float = 0.0, start_us: int = 0) -> None:
        self._utimes, self._start_us = utimes, start_us
        if utimes is not None:
            rate_hz = 1e6 / float(np.median(np.diff(utimes))) if len(utimes) > 1 else ONE_PICTURE_HZ
        self.rate_hz = rate_hz
        """The typical rate."""

    def at_us(self, frame: int) -> int:
        """Return the time of a frame; after the last recorded time it goes on at the typical rate."""
        if self._utimes is None:
            return self._start_us + round(frame * 1e6 / self.rate_hz)
        last = len(self._utimes) - 1
        if frame <= last:
            return int(self._utimes[frame])
        return int(self._utimes[last]) + round((frame - last) * 1e6 / self.rate_hz)

    def has(self, frame: int) -> bool:
        """Whether the time of a frame is known."""
        return self._utimes is None or frame < len(self._utimes)

    @property
    def last_us(self) -> int | None:
        """The last recorded time, None at a constant rate."""
        return None if self._utimes is None else int(self._utimes[-1])
