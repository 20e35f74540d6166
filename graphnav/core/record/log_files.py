"""A log in one file, or split into numbered files."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from graphnav.core.errors import LogError
from graphnav.core.messages import About
from graphnav.core.record.about_first import is_about
from graphnav.core.record.event import HEADER
from graphnav.core.record.log_paths import numbered
from graphnav.core.record.writer import LogWriter

_CHECK_S = 0.5
_CHECK_BYTES = 1 << 18
"""Free disk space is checked after this time or number of bytes, whichever comes first."""


class Split(NamedTuple):
    """When to start a new file: before one exceeds ``n_bytes``, or ``us`` microseconds after its first event."""

    n_bytes: int | None = None
    us: int | None = None


class LogFiles:
    """A log in one file, or, with ``split``, in numbered files of which the newest ``rotate`` are kept.

    Each file after the first begins with the newest description of a run, and so does a file that lost its own when the
    disk was full. The first file has the number 0; without ``numbers_first`` it has the name of ``path`` itself.
    ``free_quota_bytes``: the recording ends when less disk space is free. ``free_bytes`` returns the free disk space.

    Raises OSError if the first file cannot be opened, LogError if less is free at the start.
    """

    def __init__(
        self,
        path: Path,
        split: Split | None = None,
        rotate: int | None = None,
        free_quota_bytes: int | None = None,
        free_bytes: Callable[[Path], int] = lambda folder: shutil.disk_usage(folder).free,
        *,
        numbers_first: bool = True,
    ) -> None:
        self._path, self._split, self._rotate = path, split, rotate
        self._quota_bytes, self._free_bytes = free_quota_bytes, free_bytes
        self._checked_s = 0.0
        self._checked_bytes = 0
        self._number = 0
        self._about = b""
        self._n_events = self._n_bytes = self._n_copies = 0
        self._begin_us: int | None = None
        self._before_us: int | None = None
        """The timestamp of the last event of the file before."""
        self.paths = [numbered(path, 0) if split is not None and numbers_first else path]
        """Existing files, oldest first."""
        if free_quota_bytes is not None:
            self._look_at_disk(free_quota_bytes)
        self._log = LogWriter(self.paths[0])

    @property
    def n_events(self) -> int:
        """The number of events written, including removed files."""
        return self._n_events + max(0, self._log.n_events - self._n_copies)

    @property
    def last_us(self) -> int | None:
        """The timestamp of the last event, None without one."""
        return self._before_us if self._log.last_us is None else self._log.last_us

    @property
    def n_bytes(self) -> int:
        """The size of all files, including removed ones."""
        return self._n_bytes + self._log.n_bytes

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Append an event, in a new file if it is due; raises LogError if the disk refuses it."""
        if self._quota_bytes is not None:
            self._check_quota(self._quota_bytes)
        if self._begin_us is None:
            self._begin_us = utime
        elif self._split is not None and self._is_full(self._split, utime, HEADER.size + len(channel) + len(data)):
            self._begin_file(utime, is_description=is_about(channel, data))
        if is_about(channel, data):
            self._about = data
        self._log.write(channel, utime, data)

    def flush(self) -> None:
        """Hand all events to the kernel."""
        if self._quota_bytes is not None:
            self._check_quota(self._quota_bytes)
        self._log.flush()

    def resume(self, room_bytes: int = 0) -> None:
        """Accept events again after a write error; raises LogError if the disk has not ``room_bytes`` for more."""
        self._log.resume(room_bytes)
        if self._log.n_events == 0:  # the description was lost, too
            self._n_copies = 0
            if self._about:
                self._copy_about(self._begin_us or 0)

    def close(self) -> None:
        """Flush and close; idempotent."""
        self._log.close()

    def _is_full(self, split: Split, utime: int, n_bytes: int) -> bool:
        if self._begin_us is None or self._log.n_events <= self._n_copies:
            return False
        max_bytes, max_us = split
        return (max_bytes is not None and self._log.n_bytes + n_bytes > max_bytes) or (
            max_us is not None and utime - self._begin_us >= max_us
        )

    def _begin_file(self, utime: int, *, is_description: bool) -> None:
        self._log.flush()
        path = numbered(self._path, self._number + 1)
        try:
            following = LogWriter(path)
        except OSError as error:
            raise LogError(f"{path}: {error.strerror}") from error
        self._log.close()
        self._before_us = self._log.last_us
        self._n_events, self._n_bytes = self.n_events, self.n_bytes
        self._log, self._n_copies = following, 0
        self._number += 1
        self.paths.append(path)
        self._begin_us = utime
        if self._about and not is_description:
            self._copy_about(utime)
        if self._rotate is not None:
            self._remove_oldest(self._rotate)

    def _copy_about(self, utime: int) -> None:
        """Begin a file with the description of the run."""
        self._n_copies = 1
        self._log.write(About.CHANNEL, utime, self._about)

    def _remove_oldest(self, n_kept: int) -> None:
        while len(self.paths) > n_kept:
            oldest = self.paths.pop(0)
            try:
                oldest.unlink(missing_ok=True)
            except OSError as error:
                raise LogError(f"cannot remove {oldest}: {error.strerror}") from error

    def _check_quota(self, quota_bytes: int) -> None:
        n_bytes = self.n_bytes
        if time.monotonic() - self._checked_s >= _CHECK_S or n_bytes - self._checked_bytes >= _CHECK_BYTES:
            self._checked_bytes = n_bytes
            self._look_at_disk(quota_bytes)

    def _look_at_disk(self, quota_bytes: int) -> None:
        self._checked_s = time.monotonic()
        free_bytes = self._free_bytes(self._path.parent)
        if free_bytes < quota_bytes:
            raise LogError(f"{self.paths[-1]}: {free_bytes} bytes are free on its disk, less than --quota requires")
