"""How long a process takes by itself: what it waits while others have the processors does not count."""

from __future__ import annotations

import time
from pathlib import Path


class OwnTime:
    """Measures from now on the time of a process, without that for which its main thread waited for a processor."""

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self._begin_s = time.monotonic()
        self._waited_before_s = self._waited_s = _waited_s(pid)

    def elapsed_s(self) -> float:
        """Return the time so far, seconds; of a process that has ended what it waited last is not known."""
        self._waited_s = max(self._waited_s, _waited_s(self._pid))
        return time.monotonic() - self._begin_s - (self._waited_s - self._waited_before_s)


def _waited_s(pid: int) -> float:
    """Return how long a process has waited for a processor since it began, 0 if it has ended or that is not known."""
    try:
        return int(Path(f"/proc/{pid}/schedstat").read_text(encoding="ascii").split()[1]) / 1e9
    except (OSError, ValueError, IndexError):
        return 0.0
