"""A line in the terminal that is written again and again."""

from __future__ import annotations

import shutil
import sys
from types import TracebackType
from typing import Self


class StatusLine:
    """Shows the newest line where standard output is a terminal, nothing elsewhere; it is gone when left."""

    def __init__(self) -> None:
        self._is_shown = sys.stdout is not None and sys.stdout.isatty()

    def show(self, line: str) -> None:
        """Replace the line; what does not fit the terminal is cut off."""
        if self._is_shown:
            columns = shutil.get_terminal_size().columns
            print(f"\r\x1b[K{line[: columns - 1]}", end="", flush=True)

    def clear(self) -> None:
        """Remove the line."""
        self.show("")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.clear()
