"""``graphnav spy`` in a terminal of its own: what stands on its screen, and the keys that are pressed."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self

from acceptance.drives import GRAPHNAV
from acceptance.processes import PATIENCE_S
from graphnav.spy.screen.columns import GAP, layout

HAS_TMUX = shutil.which("tmux") is not None


class SpyTerminal:
    """While entered, the spy listens on ``url`` and draws on a terminal of ``cols`` x ``rows``."""

    def __init__(self, url: str, cols: int, rows: int) -> None:
        self.cols = cols
        self._folder = tempfile.TemporaryDirectory()
        self._socket = str(Path(self._folder.name) / "tmux")
        self._size = ("-x", str(cols), "-y", str(rows))
        self._command = f"exec env -u COLUMNS -u LINES {shlex.join([str(GRAPHNAV), 'spy', url])}"
        self.pid = 0

    @property
    def is_alive(self) -> bool:
        """Whether the spy goes on: the terminal ends with it."""
        return self._run("has-session") == 0

    def press(self, *keys: str) -> None:
        """Press keys, or type text."""
        self._tmux("send-keys", *keys)

    def screen(self) -> list[str]:
        """Return the lines that stand on the screen."""
        return self._tmux("capture-pane", "-p").splitlines()

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
        self._tmux("resize-window", "-x", str(cols), "-y", str(rows))
        self.cols = cols

    def wait_for(self, holds: Callable[[list[str]], bool]) -> None:
        """Wait until something holds for the screen; raise TimeoutError, with the screen, where it never does."""
        end_s = time.monotonic() + PATIENCE_S
        while not holds(shown := self.screen()):
            if time.monotonic() > end_s:
                raise TimeoutError("\n".join(shown))
            time.sleep(0.2)

    def __enter__(self) -> Self:
        with_colour = ("-e", "COLORTERM=truecolor")
        self._tmux("-f", os.devnull, "new-session", "-d", *self._size, *with_colour, self._command)
        self.pid = int(self._tmux("display-message", "-p", "#{pane_pid}"))
        self.wait_for(lambda lines: any("graphnav spy" in line for line in lines))
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._run("kill-server")
        self._folder.cleanup()

    def _tmux(self, *words: str) -> str:
        command = ["tmux", "-S", self._socket, *words]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    def _run(self, *words: str) -> int:
        return subprocess.run(["tmux", "-S", self._socket, *words], capture_output=True, check=False).returncode
