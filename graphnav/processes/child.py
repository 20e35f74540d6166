"""``python -m graphnav.processes.child ADDRESS PARENT``: the process in which some stages of a run live."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import sys

from graphnav.core.machine import peer_of
from graphnav.processes.frames import with_room

_PR_SET_PDEATHSIG = 1


def main() -> int:
    """Serve the run until it closes its side."""
    link = connected(sys.argv[1], int(sys.argv[2]))
    if link is None:
        return 1
    from graphnav.processes.hosted_stages import serve  # noqa: PLC0415 - it takes time, in which the run may end

    serve(link)
    return 0


def connected(address: str, parent: int) -> socket.socket | None:
    """Let this process end with the one that has started it, and connect to that; None if another one listens there."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)  # with the thread that started it
    if os.getppid() != parent:
        return None
    for number in (signal.SIGINT, signal.SIGTERM):  # sent to a group: this process ends with the run
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])  # blocked signals are inherited from the parent thread
    link = with_room(socket.socket(socket.AF_UNIX, socket.SOCK_STREAM))
    link.connect(address)
    return link if peer_of(link) == (parent, os.getuid()) else None


if __name__ == "__main__":
    sys.exit(main())
