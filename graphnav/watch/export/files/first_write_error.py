"""A file for libraries that ignore write errors: the first error is kept, and raised on request."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any


class QuietFile:
    """A writable binary file. After the first error it discards all data; `check` raises that error."""

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb", buffering=0)
        self._error: OSError | None = None
        self._at = self._size = 0

    def write(self, data: Any) -> int:
        """Write all bytes, or keep the error; return the number of bytes."""
        view = memoryview(data).cast("B")
        done = 0
        try:
            while self._error is None and done < len(view):
                done += self._file.write(view[done:])
        except OSError as error:
            self._error = error
        self._at += len(view)
        self._size = max(self._size, self._at)
        return len(view)

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Seek, as if all writes had succeeded; return the position."""
        self._at = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._size}[whence]
        if self._error is None:
            self._file.seek(self._at)
        return self._at

    def flush(self) -> None:
        """Do nothing: the file is not buffered."""

    def check(self) -> None:
        """Raise the first error, OSError, if there was one."""
        if self._error is not None:
            raise self._error

    def close(self) -> None:
        """Close, and raise the first error."""
        self._file.close()
        self.check()
