"""A terminal to look at: tmux runs a program in it, and tells what stands on its screen."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

PATIENCE_S = 60.0


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
