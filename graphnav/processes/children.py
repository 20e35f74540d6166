"""Start processes of stages on this machine, take their connections, and end them with all that they have started."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection
from contextlib import suppress
from typing import IO

from graphnav import GraphnavError
from graphnav.core.machine import ONE_THREAD, environment_alike, peer_of
from graphnav.processes.descriptors import is_readable
from graphnav.processes.frames import with_room
from graphnav.processes.output_lines import OutputLines
from graphnav.processes.warden import VARIABLE, end_marked, remove_folder
from graphnav.processes.wardens import Wardens


class Running:
    """A process from its start to its end."""

    def __init__(self, popen: subprocess.Popen[bytes], mark: str, output: OutputLines) -> None:
        self.popen, self.mark, self.output = popen, mark, output
        self.pid_fd = os.pidfd_open(popen.pid)

    def has_ended_within(self, seconds: float) -> bool:
        """Wait for its end; it is not collected, so that its group is still its own."""
        return is_readable(self.pid_fd, seconds)


class Children:
    """The processes of a run, or those that one host has of it, a warden over them, and the socket they connect to.

    ``run``: its id. ``backlog``: how many connect at a time.

    Raises
    ------
    GraphnavError
        The socket cannot be made.
    """

    def __init__(self, run: str, backlog: int) -> None:
        self._run = run
        self._folder, self.listener = _listening(backlog)
        self._wardens = Wardens(f"{run}/", self._folder)

    @property
    def warden_pid(self) -> int:
        """The process of the warden."""
        return self._wardens.pid

    def start(self, name: str, module: str, read: Callable[[IO[bytes]], OutputLines]) -> Running:
        """Start a process; raises OSError if it cannot be started. No Ctrl-C may come meanwhile.

        ``name``: its own among all that this starts. ``module``: what it runs, with the address to connect to and the
        number of this process. ``read`` gets what it prints.
        """
        mark = f"{self._run}/{name}"
        marks = " ".join(filter(None, (os.environ.get(VARIABLE), mark)))
        command = [sys.executable, "-u", "-P", "-m", module, self.listener.getsockname(), str(os.getpid())]
        popen = subprocess.Popen(  # noqa: S603 - it is this program
            command,
            env=os.environ | ONE_THREAD | environment_alike() | {VARIABLE: marks},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._wardens.add(popen.pid)
        assert popen.stdout is not None, "it has a pipe"
        return Running(popen, mark, read(popen.stdout))

    def accept(self, expected: Collection[int]) -> tuple[int, socket.socket] | None:
        """Take a connection, of one of the expected processes, with its number; close that of any other."""
        link, _ = self.listener.accept()
        pid, user = peer_of(link)
        if pid in expected and user == os.getuid():
            return pid, with_room(link)
        link.close()
        return None

    def reap(self, running: Running, *, scans: bool = True) -> int:
        """Collect a process, which is killed if it runs, and end what it has started; return its exit status."""
        with suppress(OSError):
            os.killpg(running.popen.pid, signal.SIGKILL)
        status = running.popen.wait()
        if scans:
            end_marked(running.mark)
        self._wardens.remove(running.popen.pid)
        os.close(running.pid_fd)
        running.output.close()
        return status

    def close(self) -> None:
        """End what is left."""
        self.listener.close()
        end_marked(f"{self._run}/")
        remove_folder(self._folder)
        self._wardens.close()


def _listening(backlog: int) -> tuple[str, socket.socket]:
    """Return the folder of a socket, which is this user's alone, and the socket."""
    try:
        folder = tempfile.mkdtemp(prefix="graphnav-")  # its mode is 0700
        listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        listener.bind(os.path.join(folder, "run"))
        listener.listen(backlog)
    except OSError as error:
        where = tempfile.gettempdir()
        raise GraphnavError(
            f"no socket in {where} for the processes: {error}\n  set TMPDIR to another folder"
        ) from error
    return folder, listener
