"""Keep one warden over the processes of a run."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from contextlib import suppress

from graphnav.processes import warden
from graphnav.processes.warden import FINISHED, VARIABLE

_CLOSE_S = 2.0
_MAX_STARTS = 100
"""One that ends by itself each time is not started for ever."""


class Wardens:
    """Starts a warden, and another one whenever it ends before the run does.

    ``mark``: how the marks of all processes of the run begin. ``folder``: that of its sockets, which a warden removes.
    """

    def __init__(self, mark: str, folder: str) -> None:
        self._mark, self._folder = mark, folder
        self._groups: set[int] = set()
        self._lock = threading.Lock()
        self._is_closing = False
        self._start()
        self._thread = threading.Thread(target=self._replace, name="graphnav warden", daemon=True)
        self._thread.start()

    @property
    def pid(self) -> int:
        """The process of the warden."""
        return self._process.pid

    def add(self, group: int) -> None:
        """Watch over a process group."""
        with self._lock:
            self._groups.add(group)
            self._tell(b"%d\n" % group)

    def remove(self, group: int) -> None:
        """Let a process group be, which is gone."""
        with self._lock:
            self._groups.discard(group)
            self._tell(b"-%d\n" % group)

    def close(self) -> None:
        """End the warden: the processes are gone."""
        with self._lock:
            self._is_closing = True
            self._tell(FINISHED)
            with suppress(OSError):
                self._pipe.close()
        self._thread.join(_CLOSE_S)

    def _start(self) -> None:
        arguments = [self._mark, self._folder, str(os.getpid())]
        environment = {name: value for name, value in os.environ.items() if name != VARIABLE}
        self._process = subprocess.Popen(  # noqa: S603 - it is this program
            [sys.executable, "-I", "-S", warden.__file__, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
            start_new_session=True,
            bufsize=0,
        )
        assert self._process.stdin is not None, "it has a pipe"
        self._pipe = self._process.stdin

    def _replace(self) -> None:
        for _ in range(_MAX_STARTS):
            self._process.wait()
            with self._lock:
                if self._is_closing:
                    return
                self._pipe.close()
                try:
                    self._start()
                except OSError:  # no memory, or too many processes: the next one would not start either
                    return
                for group in self._groups:
                    self._tell(b"%d\n" % group)

    def _tell(self, said: bytes) -> None:
        with suppress(OSError):  # it has just ended, and the next one is told
            self._pipe.write(said)
