"""Schedule the reports of a listening command."""

from __future__ import annotations

import time

_EVERY_S = 1.0


class ReportTimes:
    """Once a second, but not in the half second before the final report. ``for_s``: None for no end."""

    def __init__(self, for_s: float | None) -> None:
        self._last_s = time.monotonic()
        self._end_s = None if for_s is None else self._last_s + for_s

    def is_due(self) -> bool:
        """Whether to print now; the next report is one second after it."""
        now_s = time.monotonic()
        if now_s - self._last_s < _EVERY_S or (self._end_s is not None and self._end_s - now_s < _EVERY_S / 2):
            return False
        self._last_s = now_s
        return True
