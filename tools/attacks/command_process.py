"""A process that runs many commands one after another, and how its parent talks to it.

Python and the libraries take a second to start; a command on a spoiled file takes milliseconds.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
import time
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

from attacks.memory import forget_peak, peak_mb
from attacks.own_time import OwnTime
from attacks.verdict import MAX_S, Outcome

RENEWED_AFTER = 200
"""Commands, after which the process is started again."""
_WAIT_S = 2 * MAX_S
_LOOK_S = 1.0


class CommandProcess:
    """Runs commands in another process; starts it again when it has died, hangs, or has run `RENEWED_AFTER`.

    ``folder``: the working folder of the commands, where hostile names of files may make some.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._context = get_context("spawn")
        self._start()

    def run(self, words: list[str]) -> Outcome:
        """Return the outcome of a command."""
        if self._count >= RENEWED_AFTER:
            self.close()
            self._start()
        self._count += 1
        own_time = OwnTime(self._process.pid or 0)
        self._ours.send(words)
        try:
            while own_time.elapsed_s() < _WAIT_S:
                if self._ours.poll(_LOOK_S):
                    outcome: Outcome = self._ours.recv()
                    return outcome
            died = ""
        except EOFError:
            self._process.join()
            died = f"the process: exit code {self._process.exitcode}"
        elapsed_s = own_time.elapsed_s()
        self.close()
        self._start()
        return Outcome(1 if died else None, "", elapsed_s, 0.0, died)

    def close(self) -> None:
        """End the process."""
        self._process.kill()
        self._process.join()
        self._ours.close()

    def _start(self) -> None:
        self._count = 0
        self._ours, theirs = self._context.Pipe()
        self._process = self._context.Process(target=_serve, args=(theirs, self._folder), daemon=True)
        self._process.start()
        theirs.close()


def _serve(connection: Connection, folder: Path) -> None:
    """Run commands until the parent closes the connection."""
    from attacks import python_door  # noqa: PLC0415 - in the process that runs commands
    from graphnav.core.cli import main  # noqa: PLC0415

    os.environ["COLUMNS"] = "100"
    os.chdir(folder)
    sys.stdin = open(os.devnull)  # noqa: SIM115 - as long as the process
    while True:
        try:
            words = connection.recv()
        except EOFError:
            return
        printed = io.StringIO()
        forget_peak()
        own_time, begin_cpu_s = OwnTime(os.getpid()), time.process_time()
        escaped, status = "", 1
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            try:
                status = python_door.main(words[1:]) if words[0] == python_door.DOOR else main(words)
            except SystemExit as ended:
                status = ended.code if isinstance(ended.code, int) else 1
            except BaseException as error:  # noqa: BLE001 - whatever escapes is a fault
                escaped = f"{type(error).__name__}: {str(error)[:200]}"
        elapsed_s, cpu_s = own_time.elapsed_s(), time.process_time() - begin_cpu_s
        connection.send(Outcome(status, printed.getvalue(), elapsed_s, peak_mb(os.getpid()), escaped, cpu_s))
