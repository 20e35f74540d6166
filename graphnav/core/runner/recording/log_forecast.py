"""Forecast the size of a log early in the run."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from graphnav.core.spec import RecordOption

_FROM_TICK, _TO_TICK = 2, 20
"""The first ticks differ: they contain messages that are published once, and no flow."""
_LARGE_BYTES = 1e9
_MAX_DISK_RATIO = 0.8
_FOR_SMALL = "for small messages only: --set run.record=small"
_HINTS: Mapping[RecordOption, str] = {
    "all": f"for what a replay needs to make the rest again: --set run.record=replayable; {_FOR_SMALL}",
    "replayable": _FOR_SMALL,
    "small": "",
}


class SizedLog(Protocol):
    """A log that knows its size."""

    @property
    def n_bytes(self) -> int:
        """Size of the log, including unflushed bytes."""


class LogForecast:
    """Warns once, after 20 ticks, if the log will exceed 1 GB or 80 % of the free space of its disk.

    ``until_s``: the latest end of the run, None if unknown; then there is no warning. ``option``: what the log keeps.
    """

    def __init__(
        self,
        until_s: float | None,
        log: SizedLog,
        folder: Path,
        notice: Callable[[str], None],
        free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        option: RecordOption = "all",
    ) -> None:
        self._until_s, self._log, self._folder, self._notice = until_s, log, folder, notice
        self._free_bytes, self._hint = free_bytes, _HINTS[option]
        self._ticks = 0
        self._begin = (0, 0)

    def before_tick(self, utime: int) -> None:
        """Handle the stamp of the next tick in microseconds."""
        if self._until_s is None or self._ticks > _TO_TICK:
            return
        if self._ticks == _FROM_TICK:
            self._begin = utime, self._log.n_bytes
        elif self._ticks == _TO_TICK and utime > self._begin[0]:
            self._tell(utime, self._until_s)
        self._ticks += 1

    def _tell(self, utime: int, until_s: float) -> None:
        rate = (self._log.n_bytes - self._begin[1]) / (utime - self._begin[0])
        pending_bytes = rate * max(0.0, until_s * 1e6 - utime)
        n_bytes, free_bytes = self._log.n_bytes + pending_bytes, self._free_bytes(self._folder)
        is_tight = pending_bytes > _MAX_DISK_RATIO * free_bytes
        if n_bytes > _LARGE_BYTES or is_tight:
            free = f", {size_text(free_bytes)} are free" if is_tight else ""
            self._notice(f"the log will take about {size_text(n_bytes)} by {until_s:g} s{free}; {self._hint}")


def size_text(n_bytes: float) -> str:
    """Return a size with its unit: ``12 kB``, ``263 MB``, ``1.4 GB``."""
    for unit in ("B", "kB", "MB"):
        if n_bytes < 999.5:
            return f"{n_bytes:.0f} {unit}"
        n_bytes /= 1e3
    return f"{n_bytes:.1f} GB"
