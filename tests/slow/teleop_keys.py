"""``graphnav teleop`` in a terminal of its own, whose keys are pressed by a program."""

from __future__ import annotations

import os
import pty
import subprocess
import threading
import time
from contextlib import suppress
from types import TracebackType
from typing import Self

from testbed.drives import GRAPHNAV
from testbed.processes import end

_REPEAT_S = 0.05


class TeleopKeys:
    """While entered, teleop runs on ``url`` and reads what `press` and `hold` type."""

    def __init__(self, url: str) -> None:
        self._keyboard, terminal = pty.openpty()
        command = [str(GRAPHNAV), "teleop", "--url", url]
        self._process = subprocess.Popen(
            command, stdin=terminal, stdout=terminal, stderr=terminal, start_new_session=True
        )
        os.close(terminal)
        threading.Thread(target=self._read, daemon=True).start()

    def press(self, key: str) -> None:
        """Type a key once."""
        os.write(self._keyboard, key.encode())

    def hold(self, key: str, for_s: float) -> None:
        """Type a key again and again, as a terminal does while it is held down."""
        end_s = time.monotonic() + for_s
        while time.monotonic() < end_s:
            self.press(key)
            time.sleep(_REPEAT_S)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.press("q")
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(5)
        end(self._process)
        os.close(self._keyboard)

    def _read(self) -> None:
        """Take what is shown, so that the terminal never fills."""
        with suppress(OSError):
            while os.read(self._keyboard, 4096):
                pass
