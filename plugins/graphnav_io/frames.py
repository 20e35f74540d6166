"""Interface of frame readers."""

from __future__ import annotations

from typing import Protocol

from graphnav.arrays import Bytes


class Frames(Protocol):
    """A sequence of frames; ``rate_hz`` is its own rate, 0 if it has none."""

    rate_hz: float

    def read(self) -> Bytes | None:
        """Return the next frame, uint8 (rows, cols) or (rows, cols, 3) red-green-blue, None after the last.

        Raises
        ------
        ValueError
            The frame cannot be decoded.
        """

    @property
    def at_end(self) -> bool:
        """Whether no frame is left, as far as known without waiting for one."""

    def close(self) -> None:
        """Close files and devices."""
