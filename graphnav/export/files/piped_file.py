"""A path for libraries that write to paths only and hang on a full disk: a pipe that a thread empties into a file."""

from __future__ import annotations

import os
import threading
from pathlib import Path

from graphnav.export.files.first_write_error import QuietFile

_READ_BYTES = 1 << 20


class PipedFile:
    """What is written to ``path`` arrives in ``file``, in order; whoever writes may not seek.

    Call `opened` as soon as the library has opened the path, and `close` when it has closed it.
    """

    def __init__(self, file: Path) -> None:
        self._file = QuietFile(file)
        self._reading, self._writing = os.pipe()
        self.path = f"/dev/fd/{self._writing}"
        self._thread = threading.Thread(target=self._empty, name="graphnav export", daemon=True)
        self._thread.start()

    def opened(self) -> None:
        """Let the library have the only end that writes, so that the end of the file is received."""
        os.close(self._writing)

    def check(self) -> None:
        """Raise the first error of the disk, OSError, if there was one."""
        self._file.check()

    def close(self) -> None:
        """Wait for what is on its way, close the file, and raise the first error."""
        self._thread.join()
        os.close(self._reading)
        self._file.close()

    def _empty(self) -> None:
        while data := os.read(self._reading, _READ_BYTES):
            self._file.write(data)
