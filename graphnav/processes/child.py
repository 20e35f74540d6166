"""``python -m graphnav.processes.child ADDRESS PARENT``: the process in which some stages of a run live."""

from __future__ import annotations

import ctypes
import os
import signal
import socket
import sys

from graphnav.core.machine import peer_of

_PR_SET_PDEATHSIG = 1


def main() -> int:
    """Serve the run until it closes its side."""
    address, parent = sys.argv[1], int(sys.argv[2])
    end_with(parent)
    for number in (signal.SIGINT, signal.SIGTERM):  # sent to a group: this process ends with the run
        signal.signal(number, signal.SIG_IGN)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])  # blocked signals are inherited from the parent thread
    link = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    link.connect(address)
    if peer_of(link) != (parent, os.getuid()):
        return 1
    from graphnav.processes.hosted_stages import serve  # noqa: PLC0415 - it takes time, in which the run may end

    serve(link)
    return 0


def end_with(parent: int) -> None:
    """Let the kernel end this process with the thread that started it."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:
        os._exit(1)


if __name__ == "__main__":
    sys.exit(main())
