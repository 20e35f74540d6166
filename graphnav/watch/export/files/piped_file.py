"""A pipe copied to a file, for libraries that write only to paths and hang on a full disk."""

from __future__ import annotations

import os
import threading
from pathlib import Path

from graphnav.watch.export.files.first_write_error import QuietFile

_READ_BYTES = 1 << 20


class PipedFile:
    """Copies the data written to the pipe ``path`` to ``file``; the writer must not seek.

    Call `opened` as soon as the library has opened the path, and `close` when it has closed it.
    """

    def __init__(self, file: Path) -> None:
        self._file = QuietFile(file)
        self._reading, self._writing = os.pipe()
        self.path = f"/dev/fd/{self._writing}"
        self._thread = threading.Thread(target=self._empty, name="graphnav export", daemon=True)
        self._thread.start()

    def opened(self) -> None:
        """Close our writing end, so that the end of the data is detected when the library closes its own."""
        os.close(self._writing)

    def check(self) -> None:
        """Raise the first write error, OSError, if there was one."""
        self._file.check()

    def close(self) -> None:
        """Wait for the remaining data, close the file, and raise the first error."""
        self._thread.join()
        os.close(self._reading)
        self._file.close()

    def _empty(self) -> None:
        while data := os.read(self._reading, _READ_BYTES):
            self._file.write(data)
