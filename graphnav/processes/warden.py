"""The warden of a run: ends all of its processes when the program that started them is gone, however that ended.

Started by `graphnav.processes.wardens` as a script in a session of its own, which imports the standard library alone.
It is told the process groups through a pipe; processes that left their group are known by their environment.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import sys
import time

VARIABLE = "GRAPHNAV_PROCESS"
"""The environment variable of a process of a run: the marks of the process and of those that it was started within."""
FINISHED = b"finished\n"

_ROUNDS = 3
"""So many rounds must find nothing: a process that is being started shows its environment a moment later."""
_PERIOD_S = 0.03
_PATIENCE_S = 10.0
_CHUNK_BYTES = 65_536


def marks_of(pid: int) -> list[str]:
    """Return the marks in the environment of a process; none of one that has ended, or is another user's."""
    try:
        with open(f"/proc/{pid}/environ", "rb") as file:
            variables = file.read().split(b"\0")
    except OSError:
        return []
    name = VARIABLE.encode() + b"="
    return [mark.decode("ascii", "replace") for v in variables if v.startswith(name) for mark in v[len(name) :].split()]


def end_marked(mark: str) -> int:
    """Kill all processes with a mark that begins like this one; return how many that were."""
    n_killed = 0
    for name in os.listdir("/proc"):
        if name.isdigit() and int(name) != os.getpid():
            n_killed += _end(int(name), mark)
    return n_killed


def _end(pid: int, mark: str) -> bool:
    """Kill a process if it has the mark, and no other one that may have got its number since."""
    if not any(one.startswith(mark) for one in marks_of(pid)):
        return False
    try:
        fd = os.pidfd_open(pid)
    except OSError:
        return False
    try:
        if any(one.startswith(mark) for one in marks_of(pid)):
            signal.pidfd_send_signal(fd, signal.SIGKILL)
            return True
    except OSError:
        pass
    finally:
        os.close(fd)
    return False


def remove_folder(folder: str) -> None:
    """Remove the folder of the sockets."""
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            os.unlink(os.path.join(folder, name))
        os.rmdir(folder)


def _wait(parent: int) -> set[int] | None:
    """Wait until the program is gone; return the groups that it left, None if it has ended them itself."""
    groups: set[int] = set()
    pending = b""
    poll = select.poll()
    poll.register(0, select.POLLIN | select.POLLHUP)
    with contextlib.suppress(OSError):
        poll.register(os.pidfd_open(parent), select.POLLIN)  # forked children may keep the pipe open
    while True:
        ready = [fd for fd, _ in poll.poll()]
        data = os.read(0, _CHUNK_BYTES) if 0 in ready else b""
        if not data:
            return groups
        *lines, pending = (pending + data).split(b"\n")
        for line in lines:
            if line + b"\n" == FINISHED:
                return None
            number = int(line)
            groups.add(number) if number > 0 else groups.discard(-number)


def main() -> None:
    """Wait, then end what is left."""
    mark, folder, parent = sys.argv[1], sys.argv[2], int(sys.argv[3])
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])  # blocked signals are inherited from the parent thread
    groups = _wait(parent) if os.getppid() == parent else set()
    if groups is None:
        return
    for group in groups:
        with contextlib.suppress(OSError):
            os.killpg(group, signal.SIGKILL)
    end_s, n_quiet = time.monotonic() + _PATIENCE_S, 0
    while n_quiet < _ROUNDS and time.monotonic() < end_s:
        n_quiet = 0 if end_marked(mark) else n_quiet + 1
        time.sleep(_PERIOD_S)
    remove_folder(folder)


if __name__ == "__main__":
    main()
