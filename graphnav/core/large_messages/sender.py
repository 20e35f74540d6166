"""Give large messages to the process that sends them with gaps."""

from __future__ import annotations

import mmap
import os
import select
import socket
import subprocess
import sys
import time
from collections import Counter, deque
from collections.abc import Callable
from typing import NamedTuple

from graphnav.core.large_messages import child
from graphnav.core.large_messages.child import ANSWER, MEMORY_BYTES, NUMBERS, ORDER, OVERTAKEN, SENT

_MAX_NAME_BYTES = 63
_MAX_PENDING = 64
"""So many orders and their answers fit the buffers of the socket."""
_MAX_STARTS = 2
_PATIENCE_S = 5.0
"""A process that answers nothing for so long is stopped or hangs, and is replaced."""
_CLOSE_S = 0.3


class _Pending(NamedTuple):
    """An ordered message: its location in the shared memory, and the monotonic time of the order."""

    channel: str
    at: int
    n_bytes: int
    newest_only: bool
    at_s: float


class LargeSender:
    """Sends messages to a multicast group from a process of its own, in LCM's wire format with a gap after each packet.

    The process starts with the first message, or with `start`, and ends with `close` or with this process, however that
    ends. If it dies or hangs it is started once more, then given up; ``notice`` is told. One thread owns this object.
    ``numbers``: see `NUMBERS`.
    """

    def __init__(
        self, host: str, port: int, ttl: int, notice: Callable[[str], None], numbers: tuple[int, int] = NUMBERS
    ) -> None:
        self.overtaken: Counter[str] = Counter()
        """By channel: messages that were not sent, because a newer one was pending or the process died."""
        self.refusal = 0
        """Error number of the last message that the network refused; 0 if there was none since it was set to 0."""
        self._address = host, port, ttl, *numbers
        self._notice = notice
        self._pending: deque[_Pending] = deque()
        self._process: subprocess.Popen[bytes] | None = None
        self._n_starts = 0

    def start(self) -> bool:
        """Start the process unless it runs; return whether there is one."""
        if self._process is None and self._n_starts < _MAX_STARTS:
            self._n_starts += 1
            try:
                self._start()
            except OSError as error:
                self._n_starts = _MAX_STARTS
                self._tell(f"cannot be started: {error}")
        return self._process is not None

    def is_sending(self, channel: str) -> bool:
        """Whether a message of a channel is pending, which a later one must not pass."""
        self._read_answers()
        return any(pending.channel == channel for pending in self._pending)

    def send(self, channel: str, data: bytes, *, newest_only: bool) -> bool:
        """Send a message; return whether this object takes care of it, False if it cannot.

        With ``newest_only`` it returns at once; a message that is pending when a newer one of its channel comes is not
        sent. Otherwise it returns when the message is sent, or ``refusal`` is set.
        """
        name = channel.encode("utf-8", "surrogateescape")
        if len(data) > MEMORY_BYTES or len(name) > _MAX_NAME_BYTES:
            return False
        while self.start():
            if newest_only:
                if self._post(_Pending(channel, 0, len(data), newest_only, time.monotonic()), name, data):
                    return True
            elif (
                self._finish(_PATIENCE_S)
                and self._post(_Pending(channel, 0, len(data), newest_only, time.monotonic()), name, data)
                and self._finish(_PATIENCE_S)
            ):
                return True
        return False

    def close(self) -> None:
        """Send what is pending, for at most 0.3 s, and end the process."""
        self._n_starts = _MAX_STARTS
        self._await_answers(_CLOSE_S)
        if self._process is not None:
            self._release(_CLOSE_S)

    def _start(self) -> None:
        self._orders, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        memory_fd = os.memfd_create("graphnav-large-messages")
        try:
            os.truncate(memory_fd, MEMORY_BYTES)
            self._memory = mmap.mmap(memory_fd, MEMORY_BYTES)
            arguments = map(str, (theirs.fileno(), memory_fd, os.getpid(), *self._address))
            self._process = subprocess.Popen(  # noqa: S603 - it is this program
                [sys.executable, "-I", "-S", child.__file__, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[theirs.fileno(), memory_fd],
                start_new_session=True,
            )
        except OSError:
            self._orders.close()
            raise
        finally:
            theirs.close()
            os.close(memory_fd)

    def _post(self, order: _Pending, name: bytes, data: bytes) -> bool:
        """Order a message, or count it as overtaken if there is no room; return False if the process has failed."""
        self._read_answers()
        if self._pending and order.at_s - self._pending[0].at_s > _PATIENCE_S:
            self._give_up("does not answer")
        if self._process is None:
            return False
        at = self._room_for(order.n_bytes)
        if at is None:
            self.overtaken[order.channel] += 1
            return True
        self._memory[at : at + order.n_bytes] = data
        try:
            self._orders.send(ORDER.pack(at, order.n_bytes, order.newest_only) + name, socket.MSG_DONTWAIT)
        except OSError:
            self._give_up("died")
            return False
        self._pending.append(order._replace(at=at))
        return True

    def _room_for(self, n_bytes: int) -> int | None:
        """Return where the shared memory has room for a message, None if there is none.

        It is a ring that starts again at 0 whenever nothing is pending, so that few of its pages are ever used.
        """
        if not self._pending:
            return 0
        if len(self._pending) == _MAX_PENDING:
            return None
        first, last = self._pending[0], self._pending[-1]
        end = last.at + last.n_bytes
        if last.at >= first.at:
            if end + n_bytes <= MEMORY_BYTES:
                return end
            end = 0
        return end if end + n_bytes <= first.at else None

    def _finish(self, timeout_s: float) -> bool:
        """Wait until nothing is pending; return False if the process died or did not finish, which ends it."""
        if self._await_answers(timeout_s):
            return True
        if self._process is not None:
            self._give_up("does not answer")
        return False

    def _await_answers(self, timeout_s: float) -> bool:
        """Wait until nothing is pending; return whether that is so and the process lives."""
        end_s = time.monotonic() + timeout_s
        self._read_answers()
        while self._process is not None and self._pending and (left_s := end_s - time.monotonic()) > 0:
            select.select([self._orders], [], [], left_s)
            self._read_answers()
        return self._process is not None and not self._pending

    def _read_answers(self) -> None:
        """Handle the answers that have arrived."""
        while self._process is not None and self._pending:
            try:
                answer = self._orders.recv(ANSWER.size, socket.MSG_DONTWAIT)
            except BlockingIOError:
                return
            except OSError:
                answer = b""
            if not answer:
                self._give_up("died")
                return
            (code,) = ANSWER.unpack(answer)
            done = self._pending.popleft()
            if code == OVERTAKEN:
                self.overtaken[done.channel] += 1
            elif code != SENT:
                self.refusal = code

    def _give_up(self, why: str) -> None:
        """End a process that failed; what is pending is lost."""
        status = self._release(0.0)
        self.overtaken.update(pending.channel for pending in self._pending if pending.newest_only)
        self._pending.clear()
        self._tell(f"{why} (status {status})")

    def _release(self, timeout_s: float) -> int:
        """Close the connection to the process and return its exit status; it is killed after ``timeout_s``."""
        assert self._process is not None
        self._orders.close()
        self._memory.close()
        try:
            self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        status = self._process.returncode
        self._process = None
        return status

    def _tell(self, what: str) -> None:
        then = "it is started again" if self._n_starts < _MAX_STARTS else "these now leave in bursts, without gaps"
        self._notice(f"the process that sends messages above one packet {what}: {then}")
