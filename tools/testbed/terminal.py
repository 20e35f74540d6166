"""A terminal to look at, with any program or the spy in it: tmux runs it, and tells what stands on its screen."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from graphnav.watch.spy.screen.columns import GAP, layout
from testbed.drives import GRAPHNAV

PATIENCE_S = 60.0
HAS_TMUX = shutil.which("tmux") is not None


@dataclass(frozen=True)
class Terminal:
    """A terminal in a tmux server of its own, which listens on ``socket``."""

    socket: Path

    def start(self, command: str, size: tuple[int, int], **environment: str) -> None:
        """Run a shell's command on a screen of ``size`` columns and rows."""
        variables = [word for name, value in environment.items() for word in ("-e", f"{name}={value}")]
        width, height = map(str, size)
        command = f"unset COLUMNS LINES; {command}"  # Textual takes them for the terminal's size
        self.tmux("-f", os.devnull, "new-session", "-d", "-x", width, "-y", height, *variables, command)

    def close(self) -> None:
        """End the server and what runs in it."""
        subprocess.run(["tmux", "-S", self.socket, "kill-server"], capture_output=True, check=False)

    @property
    def is_running(self) -> bool:
        """Whether the program goes on: the terminal ends with it."""
        return (
            subprocess.run(["tmux", "-S", self.socket, "has-session"], capture_output=True, check=False).returncode == 0
        )

    def tmux(self, *words: str) -> str:
        """Run a command of tmux and return what it prints."""
        done = subprocess.run(["tmux", "-S", self.socket, *words], capture_output=True, text=True, check=True)
        return done.stdout

    def press(self, *keys: str) -> None:
        """Press keys."""
        self.tmux("send-keys", *keys)

    def screen(self, *options: str) -> str:
        """Return what stands on the screen."""
        return self.tmux("capture-pane", "-p", *options)

    def wait_for(self, condition: Callable[[str], bool], patience_s: float = PATIENCE_S) -> str:
        """Return the screen as soon as a condition holds for it; raise AssertionError if it never does."""
        end_s = time.monotonic() + patience_s
        while time.monotonic() < end_s:
            if condition(shown := self.screen()):
                return shown
            time.sleep(0.1)
        raise AssertionError(f"it never came to that:\n{shown}")


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
