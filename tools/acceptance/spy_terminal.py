"""``graphnav spy`` in a terminal of its own: what stands on its screen, and the keys that are pressed."""

from __future__ import annotations

import shlex
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from acceptance.drives import GRAPHNAV
from acceptance.terminal import Terminal
from graphnav.watch.spy.screen.columns import GAP, layout

HAS_TMUX = shutil.which("tmux") is not None


class SpyTerminal:
    """While entered, the spy listens on ``url`` and draws on a terminal of ``cols`` x ``rows``."""

    def __init__(self, url: str, cols: int, rows: int) -> None:
        self.cols = cols
        self._rows = rows
        self._folder = tempfile.TemporaryDirectory()
        self._terminal = Terminal(Path(self._folder.name) / "tmux")
        self._command = f"exec {shlex.join([str(GRAPHNAV), 'spy', url])}"
        self.pid = 0

    @property
    def is_alive(self) -> bool:
        """Whether the spy goes on: the terminal ends with it."""
        return self._terminal.is_running

    def press(self, *keys: str) -> None:
        """Press keys, or type text."""
        self._terminal.press(*keys)

    def screen(self) -> list[str]:
        """Return the lines that stand on the screen."""
        return self._terminal.screen().splitlines()

    def cells(self, channel: str) -> dict[str, str]:
        """Return a channel's cells by their headings, as they stand in the table; none where it is not shown."""
        for line in self.screen():
            at, cells = 0, {}
            for column, width in layout(self.cols):
                cells[column.heading] = line[at : at + width].strip()
                at += width + GAP
            if cells["channel"] == channel:
                return cells
        return {}

    def resize(self, cols: int, rows: int) -> None:
        """Give the terminal another size."""
        self._terminal.tmux("resize-window", "-x", str(cols), "-y", str(rows))
        self.cols = cols

    def wait_for(self, holds: Callable[[list[str]], bool]) -> None:
        """Wait until something holds for the screen; raise AssertionError, with the screen, where it never does."""
        self._terminal.wait_for(lambda shown: holds(shown.splitlines()))

    def __enter__(self) -> Self:
        self._terminal.start(self._command, (self.cols, self._rows), COLORTERM="truecolor")
        self.pid = int(self._terminal.tmux("display-message", "-p", "#{pane_pid}"))
        self.wait_for(lambda lines: any("graphnav spy" in line for line in lines))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._terminal.close()
        self._folder.cleanup()
