"""What sources read frames from."""

from __future__ import annotations

from typing import Protocol

from graphnav.arrays import Bytes


class Frames(Protocol):
    """Frames one after the other; ``rate_hz`` is their own rate, 0 where they have none."""

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
        """Whether no frame is left, as far as can be told without waiting for one."""

    def close(self) -> None:
        """Release files and devices."""
