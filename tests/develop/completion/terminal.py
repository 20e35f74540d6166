"""A shell in a terminal of its own, driven by keys and read until it shows what a test waits for."""

from __future__ import annotations

import os
import pty
import re
import select
import subprocess
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

DEADLINE_S = 120.0
"""When a shell that shows nothing new is given up; no test waits for so long unless it fails."""
_CONTROL = re.compile(r"\x1b\[[0-9;?=>]*[A-Za-z]|\x1b[=>()][B0]?|\x1b\][^\x07]*\x07|[\x07\r]")


class Terminal:
    """A process whose standard streams are a terminal."""

    def __init__(self, command: Sequence[str], folder: Path, environment: Mapping[str, str]) -> None:
        self._end, other = pty.openpty()
        self._process = subprocess.Popen(
            command, cwd=folder, env=environment, stdin=other, stdout=other, stderr=other, start_new_session=True
        )
        os.close(other)
        self.shown = ""

    def press(self, keys: str) -> None:
        """Type ``keys``."""
        os.write(self._end, keys.encode())

    def wait_for(self, text: str) -> None:
        """Read until ``text`` is shown behind what was waited for before."""
        ends = time.monotonic() + DEADLINE_S
        while text not in self.shown:
            ready, _, _ = select.select([self._end], [], [], max(ends - time.monotonic(), 0.0))
            assert ready, f"{text!r} is not in {self.shown!r}"
            self.shown = _CONTROL.sub("", self.shown + os.read(self._end, 65536).decode(errors="replace"))
        self.shown = self.shown.partition(text)[2]

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.wait()
        os.close(self._end)
