"""Lines that the stages of a process print: shown with its name before each, and kept."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO

_MAX_LINE = 4096
_CLOSE_S = 1.0


def named_line(name: str, line: bytes) -> str:
    """Return a line that something of this name has printed, as it is shown."""
    return f"[{name}] {line.decode('utf-8', 'replace').rstrip()}"


class OutputLines:
    """Reads what a process prints until it ends, in a thread, and appends it to a file.

    ``show`` gets each line with the name before it. A file that cannot be written is left out; None: there is none.
    """

    def __init__(self, name: str, stream: IO[bytes], file: Path | None, show: Callable[[str], None]) -> None:
        self._name, self._stream, self._file, self._show = name, stream, file, show
        self._thread = threading.Thread(target=self._read, name=f"graphnav output of {name}", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Wait for the last lines of a process that has ended."""
        self._thread.join(_CLOSE_S)

    def _read(self) -> None:
        kept: IO[bytes] | None = None
        is_writable = True
        with self._stream:
            while line := self._stream.readline(_MAX_LINE):
                try:
                    if kept is None and is_writable and self._file is not None:
                        self._file.parent.mkdir(exist_ok=True)
                        kept = self._file.open("ab", buffering=0)
                    if kept is not None:
                        kept.write(line)
                except OSError:
                    is_writable = False
                self._show(named_line(self._name, line))
        if kept is not None:
            kept.close()
