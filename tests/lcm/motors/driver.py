"""A program that drives: it sends commands at 50 Hz, then ends, hangs or goes silent as its last argument says.

It prints the id of the process that sends its commands, and then, right before the ending, the monotonic time.
"""

from __future__ import annotations

import ctypes
import faulthandler
import os
import re
import resource
import signal
import sys
import threading
import time
from collections.abc import Callable

from graphnav.core.codec import encode
from graphnav.core.messages import Twist
from graphnav.live.motors.frames import Kind, pack
from graphnav.live.motors.sender import MotorChannel, MotorSender

N_COMMANDS = 5


def _raise() -> None:
    raise RuntimeError("a stage failed")


def _segfault() -> None:
    faulthandler.disable()
    ctypes.string_at(0)


def _exit_in_thread() -> None:
    thread = threading.Thread(target=sys.exit, args=(3,))
    thread.start()
    thread.join()


def _hold_gil() -> None:
    ctypes.PyDLL(None).usleep(30_000_000)


def _backtrack() -> None:
    re.match(r"(a|aa)+$", "a" * 60 + "b")


def _tear_frame(sender: MotorSender) -> None:
    frame = pack(Kind.COMMAND, 0, time.monotonic(), encode(Twist(0.5, 0.0), 0, 0))
    os.write(sender._writer._fd, frame[:-5])
    os.kill(os.getpid(), signal.SIGKILL)


def _fork_and_die() -> None:
    if os.fork():
        os.kill(os.getpid(), signal.SIGKILL)
    sys.stdin.read()
    os._exit(0)


def _end_with(sender: MotorSender) -> dict[str, Callable[[], object]]:
    return {
        "return": lambda: None,
        "raise": _raise,
        "sys.exit": lambda: sys.exit(3),
        "os._exit": lambda: os._exit(3),
        "exit in a thread": _exit_in_thread,
        "abort": os.abort,
        "segfault": _segfault,
        "truncated frame": lambda: _tear_frame(sender),
        "fork": _fork_and_die,
        "close": sender.close,
        "hold the GIL": _hold_gil,
        "backtrack": _backtrack,
        "be silent": sys.stdin.read,
    }


def main() -> None:
    """Drive."""
    url, name, max_age_s, ending = sys.argv[1:]
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    sender = MotorSender(url, [MotorChannel(name, encode(Twist(0.0, 0.0), 0, 0), 8, 16, float(max_age_s))])
    print(sender.pid, flush=True)
    seq = 0
    while seq < N_COMMANDS or ending == "drive on":
        sender.send(name, encode(Twist(0.5, 0.0), time.time_ns() // 1000, seq))
        seq += 1
        time.sleep(0.02)
    print(time.monotonic(), flush=True)
    _end_with(sender)[ending]()


if __name__ == "__main__":
    main()
