"""Write frames to a pipe without blocking."""

from __future__ import annotations

import array
import fcntl
import os
import termios
import threading
from collections import deque
from typing import IO

from graphnav.live.motors.frames import Kind, pack


class FrameWriter:
    """Writes frames to a pipe, which it makes non-blocking; frames that do not fit stay pending until the next call.

    At most one command of each channel is pending: the newest. An order (stop, end) replaces the pending commands and
    is written before later ones. A partially written frame is always completed first.

    May be called from any thread and from a signal handler: a call that interrupts another one in its thread leaves
    the writing to that one. Writing to a pipe that is closed or has no reader raises OSError.
    """

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe = pipe
        self._fd = pipe.fileno()
        os.set_blocking(self._fd, False)
        self._rest = b""
        self._orders: deque[bytes] = deque(maxlen=len(Kind))
        self._commands: dict[int, bytes] = {}
        self._lock = threading.RLock()
        self._is_writing = False

    @property
    def unread_bytes(self) -> int:
        """Number of bytes written but not yet read; 0 for a closed pipe."""
        count = array.array("i", [0])
        with self._lock:
            if self._fd >= 0:
                fcntl.ioctl(self._fd, termios.FIONREAD, count)
        return count[0]

    def command(self, channel: int, sent_s: float, data: bytes) -> bool:
        """Write a command; return whether it, and everything before it, is in the pipe."""
        with self._lock:
            self._commands[channel] = pack(Kind.COMMAND, channel, sent_s, data)
            return self._flush()

    def order(self, kind: Kind, sent_s: float, payload: bytes = b"") -> bool:
        """Write an order to all channels; return whether it is in the pipe."""
        with self._lock:
            self._commands = {}
            self._orders.append(pack(kind, 0, sent_s, payload))
            return self._flush()

    def close(self) -> None:
        """Close the pipe; pending frames are lost."""
        with self._lock:
            self._fd = -1
            self._pipe.close()

    @property
    def _is_empty(self) -> bool:
        return not (self._rest or self._orders or self._commands)

    def _flush(self) -> bool:
        """Write until no frame is pending or the pipe is full; return whether no frame is pending."""
        while not (self._is_writing or self._is_empty):
            self._is_writing = True
            try:
                while not self._is_empty:
                    self._write_next()
            except BlockingIOError:
                break
            finally:
                self._is_writing = False
        return self._is_empty

    def _write_next(self) -> None:
        """Write one frame, or as much of it as fits; keeps it and raises BlockingIOError if nothing fits."""
        orders, commands = self._orders, self._commands
        if frame := self._rest:
            self._rest = frame[os.write(self._fd, frame) :]
        elif orders:
            self._rest = orders[0][os.write(self._fd, orders[0]) :]
            orders.popleft()
        else:
            for channel, command in tuple(commands.items())[:1]:
                self._rest = command[os.write(self._fd, command) :]
                commands.pop(channel, None)
