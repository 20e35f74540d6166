"""A line in the terminal that is rewritten in place."""

from __future__ import annotations

import shutil
import sys
from types import TracebackType
from typing import Self

from graphnav.core.errors import shown_name
from graphnav.core.machine.escaped_streams import unescaped


class StatusLine:
    """Shows the newest line if standard output is a terminal; removed on exit."""

    def __init__(self) -> None:
        self._is_shown = sys.stdout is not None and sys.stdout.isatty()

    def show(self, line: str) -> None:
        """Replace the line; it is truncated to the terminal's width."""
        if self._is_shown:
            self.rewrite(line)

    def clear(self) -> None:
        """Remove the line."""
        self.show("")

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.clear()

    @staticmethod
    def rewrite(line: str) -> None:
        """Replace the current line of standard output, a terminal; truncated to its width."""
        terminal = unescaped(sys.stdout)
        columns = shutil.get_terminal_size().columns
        terminal.write(f"\r\x1b[K{shown_name(line)[: columns - 1]}")
        terminal.flush()
