"""The process that sends the motor channels: forwards commands, and stops the robot when they end.

Started by `graphnav.live.motors.sender`, which writes frames to its standard input. It reports on standard output,
once, whether LCM and ROS 2 are open; the only argument is the descriptor of a memory file for the counts.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import select
import signal
import sys
import time
from collections.abc import Sequence
from types import FrameType
from typing import Any

from graphnav import GraphnavError
from graphnav.live.motors.channel import MotorChannel, MotorTopic
from graphnav.live.motors.counts import Counts, SharedCounts
from graphnav.live.motors.frames import FAILED, READY, Frame, FrameReader, Kind
from graphnav.live.motors.links import MotorLinks
from graphnav.live.motors.motor import Motor
from graphnav.live.motors.schedule import STOP_FOR_S

_ENDING = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT, signal.SIGABRT)
_CHUNK_BYTES = 65_536
_COMMANDS, _OUT = 0, 1


class Child:
    """Sends the motor channels until the pipe ``commands_fd`` closes, an end is ordered or one of ``ending_fds`` wakes.

    Then it sends stops for one second, forwards nothing more, and `run` returns.
    """

    def __init__(self, motors: Sequence[Motor], commands_fd: int, ending_fds: Sequence[int]) -> None:
        self._motors = motors
        self._commands_fd = commands_fd
        self._fds = [commands_fd, *ending_fds]
        self._reader = FrameReader()
        self._end_s = math.inf
        self._overtaken = 0

    @property
    def counts(self) -> Counts:
        """Counts since the start."""
        return Counts(
            forwarded=sum(motor.forwarded for motor in self._motors),
            stops=sum(motor.stops for motor in self._motors),
            failed=sum(motor.failed for motor in self._motors),
            overtaken=self._overtaken,
            late=sum(motor.late for motor in self._motors),
        )

    def run(self, shared: SharedCounts) -> None:
        """Forward and stop until the last stop is sent."""
        while (now_s := time.monotonic()) < self._end_s:
            due_s = min((motor.due_s for motor in self._motors), default=math.inf)
            wait_s = min(due_s, self._end_s) - now_s
            ready, _, _ = select.select(self._fds, [], [], None if wait_s == math.inf else max(0.0, wait_s))
            if self._commands_fd in ready:
                ready.remove(self._commands_fd)
                self._take()
            if ready:
                self._end()
            for motor in self._motors:
                motor.stop_if_due(time.monotonic())
            shared.write(self.counts)

    def _take(self) -> None:
        """Handle the frames in the pipe; of several pending commands of a channel only the newest is forwarded.

        None of them is if the oldest one is late: nothing was forwarded for that long, and the robot has to stop first.
        """
        try:
            data = os.read(self._commands_fd, _CHUNK_BYTES)
            frames = self._reader.feed(data)
        except (OSError, ValueError):
            data, frames = b"", []
        pending: dict[int, list[Frame]] = {}
        for frame in frames:
            if frame.kind == Kind.COMMAND:
                pending.setdefault(frame.channel, []).append(frame)
            else:
                self._overtaken += sum(map(len, pending.values()))
                pending = {}
                if frame.kind == Kind.END:
                    self._end()
                    return
                self._order_stops()
        for channel, commands in pending.items():
            self._command(self._motors[channel], commands)
        if not data:
            self._end()

    def _command(self, motor: Motor, commands: Sequence[Frame]) -> None:
        """Forward the newest of the pending commands of a channel, or stop if they were not read in time."""
        oldest, newest, now_s = commands[0], commands[-1], time.monotonic()
        if motor.is_late(oldest.sent_s, now_s):
            motor.resume(len(commands), now_s)
        else:
            self._overtaken += len(commands) - 1
            motor.command(newest.payload, newest.sent_s, now_s)

    def _end(self) -> None:
        """Stop reading commands and send the final stops."""
        if self._end_s == math.inf:
            self._fds = []
            self._end_s = time.monotonic() + STOP_FOR_S
            self._order_stops()

    def _order_stops(self) -> None:
        for motor in self._motors:
            motor.order_stops(time.monotonic())


def main() -> int:
    """Open LCM and ROS 2, report it, and send until the run ends."""
    signals_fd = _signals()
    setup = _read_setup()
    if setup is None:
        return 1
    shared = SharedCounts(int(sys.argv[1]))
    channels = [_channel(words) for words in setup["channels"]]
    try:
        links = MotorLinks(setup["url"], channels)
    except GraphnavError as error:
        _say(FAILED + str(error).encode())
        return 1
    _raise_priority()
    _say(READY)
    motors = [Motor(channel, links.of(channel)) for channel in channels]
    Child(motors, _COMMANDS, [signals_fd, *_watch(setup["parent"])]).run(shared)
    links.close()
    return 0


def _channel(words: dict[str, Any]) -> MotorChannel:
    topic = words["topic"]
    stop = bytes.fromhex(words["stop"])
    return MotorChannel(**words | {"stop": stop, "topic": None if topic is None else MotorTopic(**topic)})


def _signals() -> int:
    """Return a descriptor that becomes readable on a signal to end."""
    awake_fd, signal_fd = os.pipe2(os.O_NONBLOCK)
    signal.set_wakeup_fd(signal_fd, warn_on_full_buffer=False)
    for number in _ENDING:
        signal.signal(number, _ignore)
    signal.pthread_sigmask(signal.SIG_SETMASK, [])  # blocked signals are inherited from the parent thread
    return awake_fd


def _ignore(_number: int, _frame: FrameType | None) -> None:
    """Do nothing: the signal is handled through its descriptor."""


def _read_setup() -> dict[str, Any] | None:
    """Return the content of the first frame, None if the run ended before it was complete."""
    reader = FrameReader()
    while data := os.read(_COMMANDS, _CHUNK_BYTES):
        for frame in reader.feed(data):
            setup: dict[str, Any] = json.loads(frame.payload)
            return setup
    return None


def _say(words: bytes) -> None:
    """Report to the run, once, then redirect standard output to nowhere, so that no reader waits for its end."""
    with contextlib.suppress(OSError):
        os.write(_OUT, words)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, _OUT)
    os.close(nowhere)


def _watch(parent: int) -> list[int]:
    """Return descriptors that wake when the run's process ends: its forked children may keep the pipe open.

    Empty if the kernel has no pidfd; the end of a run with such children is then noticed as silence.
    """
    try:
        fd = os.pidfd_open(parent)
    except OSError:
        return []
    return [fd]


def _raise_priority() -> None:
    """Raise the scheduling priority above ordinary processes, if permitted."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
    except OSError:
        with contextlib.suppress(OSError):
            os.nice(-10)


if __name__ == "__main__":
    sys.exit(main())
