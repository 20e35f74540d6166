"""Commands that a launcher starts quickly, as processes to signal and to wait for."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self

LAUNCHER = Path(__file__).with_name("launcher.py")


class Launched:
    """A process that a launcher started."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._fd = os.pidfd_open(pid)

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Wait for the end, but no longer than this; return whether it came."""
        return bool(select.select([self._fd], [], [], within_s)[0])

    def send(self, number: signal.Signals) -> None:
        """Send a signal; nothing where the process has ended."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self._fd, number)

    def close(self) -> None:
        """End the process at once."""
        self.send(signal.SIGKILL)
        self.has_ended(10.0)
        os.close(self._fd)


class Launcher:
    """Starts ``graphnav`` commands while it is entered."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            [sys.executable, str(LAUNCHER)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def start(self, words: Sequence[str], output: Path, environment: Mapping[str, str]) -> Launched:
        """Start a command; ``output``: the file for what it prints."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        asked = {"words": list(words), "output": str(output), "environment": dict(environment)}
        self._process.stdin.write(json.dumps(asked) + "\n")
        self._process.stdin.flush()
        return Launched(int(self._process.stdout.readline()))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.terminate()
        self._process.communicate()
