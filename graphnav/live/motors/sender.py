"""Send motor channels through a process that stops the robot however the run ends."""

from __future__ import annotations

import contextlib
import json
import os
import select
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import asdict

from graphnav.core.errors import BusError
from graphnav.live.motors.channel import MotorChannel
from graphnav.live.motors.counts import Counts, SharedCounts
from graphnav.live.motors.frames import MAX_PAYLOAD_BYTES, READY, Kind
from graphnav.live.motors.writer import FrameWriter

__all__ = ["MotorChannel", "MotorSender"]

_MODULE = "graphnav.live.motors.child"
_READY_S = 10.0
_ENDED_S = 2.0
_STALLED_S = 0.04
"""How long the process may leave a command unread: a period of a fast guard; it reads within a millisecond."""
_MAX_SETUP_BYTES = 60_000
"""Capacity of an empty pipe."""


class MotorSender:
    """A separate process that sends the motor channels: it forwards commands, and sends stops when something fails.

    A stop is sent at once and repeated at 50 Hz for one second when this process ends, for whatever reason; when `stop`
    or `close` is called; and when a channel that had a command gets none for its ``max_age_s`` (then again every
    ``max_age_s`` while it stays silent). A later command is forwarded at once and ends the stops. If the process itself
    was suspended for longer than that, it sends stops first and forwards only commands that were decided afterwards.

    The constructor returns when the process is ready (about 0.1 s). Raises BusError, with the reason, if it cannot be
    started or does not open LCM within 10 s; ValueError if two channels have the same name.
    """

    def __init__(self, url: str, channels: Sequence[MotorChannel]) -> None:
        self.refused = 0
        self._indices = {channel.name: index for index, channel in enumerate(channels)}
        if len(self._indices) != len(channels):
            raise ValueError("two motor channels have the same name")
        counts_fd = SharedCounts.new_file()
        try:
            self._counts = SharedCounts(counts_fd)
            self._process = _start(counts_fd)
        finally:
            os.close(counts_fd)
        assert self._process.stdin is not None
        self._writer = FrameWriter(self._process.stdin)
        self._is_closed = False
        try:
            self._set_up(url, channels)
            self._taken_s = time.monotonic()
        except BaseException:
            self._writer.close()
            assert self._process.stdout is not None
            self._process.stdout.close()
            self._process.kill()
            self._collect()
            raise

    @property
    def alive(self) -> bool:
        """Whether the process runs; a killed process sends no stops."""
        return self._process.poll() is None

    @property
    def pid(self) -> int:
        """The process's id."""
        return self._process.pid

    @property
    def counts(self) -> Counts:
        """Counts since the start of the process."""
        return self._counts.read()

    @property
    def stops(self) -> int:
        """Number of stops sent, over all channels."""
        return self.counts.stops

    def unread_s(self, now_s: float) -> float:
        """Return for how long the process has left commands unread, monotonic seconds; 0 below 0.04 s.

        It is then suspended or starved, and nothing is sent. Never waits.
        """
        if not self._writer.unread_bytes:
            self._taken_s = now_s
        unread_s = now_s - self._taken_s
        return unread_s if unread_s >= _STALLED_S else 0.0

    def send(self, channel: str, data: bytes, made_s: float | None = None) -> bool:
        """Forward an encoded command, decided at the monotonic time ``made_s`` (None: now); never waits.

        Return False, and count it in ``refused``, if the process does not accept commands: it ended, or has not read
        its pipe for 0.04 s. The newest command of each channel then stays pending for ``max_age_s``. Also False for
        more than 1 MiB. Raises KeyError for a channel that the constructor did not get.
        """
        index = self._indices[channel]
        if self._is_closed or len(data) > MAX_PAYLOAD_BYTES:
            self.refused += 1
            return False
        now_s = time.monotonic()
        try:
            is_taken = not self.unread_s(now_s)
            is_sent = self._writer.command(index, now_s if made_s is None else min(made_s, now_s), data) and is_taken
        except OSError:
            is_sent = False
        self.refused += not is_sent
        return is_sent

    def stop(self) -> None:
        """Stop all channels now and for one second; a later command is forwarded and ends the stops.

        Never waits; may be called from any thread and from a signal handler.
        """
        if not self._is_closed:
            with contextlib.suppress(OSError):
                self.unread_s(time.monotonic())
                self._writer.order(Kind.STOP, time.monotonic())

    def close(self, wait: bool = True) -> None:  # noqa: FBT001, FBT002
        """Stop all channels for one second and end the process.

        With ``wait`` return when it has ended, or after 2 s; a process that still runs then ends by itself.
        """
        if not self._is_closed:
            self._is_closed = True
            with contextlib.suppress(OSError):
                self._writer.order(Kind.END, time.monotonic())
            self._writer.close()
            with contextlib.suppress(RuntimeError):  # no threads can be started while Python shuts down
                threading.Thread(target=self._collect, name="graphnav-motors-end", daemon=True).start()
        if wait:
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._collect(_ENDED_S)

    def _collect(self, timeout_s: float | None = None) -> None:
        """Wait for the end of the process and release its resources; raises subprocess.TimeoutExpired."""
        self._process.wait(timeout_s)
        self._counts.close()

    def _set_up(self, url: str, channels: Sequence[MotorChannel]) -> None:
        """Send the set-up to the process and wait until it is ready; raises BusError."""
        words = json.dumps(
            {
                "url": url,
                "parent": os.getpid(),
                "channels": [asdict(channel) | {"stop": channel.stop.hex()} for channel in channels],
            }
        ).encode()
        if len(words) > _MAX_SETUP_BYTES:
            raise BusError(f"the stop messages are too long: {len(words)} bytes as JSON, at most {_MAX_SETUP_BYTES}")
        with contextlib.suppress(OSError):
            self._writer.order(Kind.SETUP, time.monotonic(), words)
        answer = self._answer()
        if answer[:1] == READY:
            return
        if answer:
            raise BusError(answer[1:].decode())
        status = self._process.wait()
        raise BusError(f"the process that sends the motor channels ended with status {status} before LCM was open")

    def _answer(self) -> bytes:
        """Return the reply of the process, empty if it ended; raises BusError if there is none in time."""
        assert self._process.stdout is not None
        with self._process.stdout as out:
            if select.select([out], [], [], _READY_S)[0]:
                return os.read(out.fileno(), select.PIPE_BUF)
        raise BusError(f"the process that sends the motor channels was not ready within {_READY_S:.0f} s")


def _start(counts_fd: int) -> subprocess.Popen[bytes]:
    """Start the process in its own session, out of reach of the terminal's signals; raises BusError.

    It uses this process's module search path, whether graphnav is installed or not.
    """
    path = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    try:
        return subprocess.Popen(  # noqa: S603 - it is this program
            [sys.executable, "-P", "-m", _MODULE, str(counts_fd)],
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            pass_fds=[counts_fd],
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": path},
        )
    except OSError as error:
        raise BusError(f"the process that sends the motor channels cannot be started: {error}") from error
