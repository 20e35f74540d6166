"""Frames between processes: their length first, then what is meant as JSON, then messages as they are.

Between a run and its processes, and between hosts (`host_link`); numbers are little-endian.
"""

from __future__ import annotations

import ctypes
import json
import socket
import struct
from collections.abc import Callable, Sequence
from contextlib import suppress
from enum import IntEnum
from typing import Any, NamedTuple

MAX_BYTES = 1 << 30
"""The largest frame; a longer one is not accepted."""

_LENGTH = struct.Struct("<I")
_HEADER = struct.Struct("<BII")
_SIZE = struct.Struct("<I")
_JOINED_BYTES = 1 << 16
"""Smaller frames are copied into one piece, which costs less than a list of pieces."""
_MAX_PIECES = 512
_WARM_BYTES = 16 << 20
"""Frames up to this size are read into memory that a `Link` keeps."""
_ENCODE, _DECODE = json.JSONEncoder(separators=(",", ":")).encode, json.JSONDecoder().decode
_ROOM_BYTES = 4 << 20
"""Of a socket between processes, as far as the machine grants it (net.core.wmem_max)."""
_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""Of ``mallopt``, in glibc's ``malloc.h``."""
_KEPT_BYTES = 64 << 20
_MAX_KEPT_PIECE_BYTES = 32 << 20
"""The highest limit that glibc takes: larger buffers are the kernel's again as soon as they are freed."""


class Kind(IntEnum):
    """The kind of a frame. The run asks, and the process answers each frame in turn, PREPARE when it is done."""

    SETUP = 0
    """Make the stages."""
    RESET = 1
    """Reset them by the seed of the run."""
    FIRE = 2
    """Step one of them."""
    METRICS = 3
    """Return the metrics of one of them."""
    CLOSE = 4
    """Close one of them."""
    ANSWER = 5
    PREPARE = 6
    """Make and reset another stage beside one of them, while that goes on."""
    PREPARED = 7
    """The stage is made, or why it cannot be."""
    DROP = 8
    """Forget that stage."""
    CHANGE = 9
    """Let that stage make all further steps; if it is not prepared, make it first."""
    JOIN = 10
    """To another host, the first: which process is wanted there. To what stands for it here: also where that is."""
    INTERRUPT = 11
    """To another host: break off the step."""
    ENDED = 12
    """Of another host, the last: by which status the process has ended."""
    CLOCK = 13
    """Of what stands for a process on a host: the clock there (`ClockState`), once a second, whatever else goes on."""


class Frame(NamedTuple):
    """A frame: ``head`` is what JSON holds, ``messages`` are encoded; views of bytes where `receive` has made it."""

    kind: int
    head: Any
    messages: tuple[bytes, ...] = ()


def keep_freed_memory() -> None:
    """Let the C library of a process keep up to 64 MiB of what is freed for the next frames, where it is glibc.

    By default a picture from 128 kB on gets new pages from the kernel and returns them when it is dropped. To take new
    pages costs several times what it costs to write to used ones. Within one process it gains nothing.
    """
    with suppress(OSError, TypeError, AttributeError):  # other systems lack the call
        mallopt = ctypes.CDLL(None).mallopt
        mallopt(_TRIM_THRESHOLD, _KEPT_BYTES)
        mallopt(_MMAP_THRESHOLD, _MAX_KEPT_PIECE_BYTES)


def with_room(link: socket.socket) -> socket.socket:
    """Return a socket of this machine after giving it room to send a large frame at once.

    Of what does not fit each piece wakes the other side, and waits for it.
    """
    link.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _ROOM_BYTES)
    return link


def send(link: socket.socket, frame: Frame) -> None:
    """Send a frame; raises OSError if the other side is gone."""
    pieces = _packed(frame)
    if sum(map(len, pieces)) <= _JOINED_BYTES:
        link.sendall(b"".join(pieces))
    else:
        _send_pieces(link, [memoryview(piece) for piece in pieces])


def receive(link: socket.socket) -> Frame:
    """Wait for a frame; its messages are views of what has arrived, which is not copied.

    Raises
    ------
    EOFError
        The other side is gone.
    OSError
        The same, while it was sending.
    ValueError
        It sent something else.
    """
    return _unpacked(_received(link, _n_bytes(_received(link, _LENGTH.size), MAX_BYTES)), lambda view: view)


class Link:
    """A side of a connection that never waits for the other side.

    It owns the socket. A frame of more than ``max_bytes`` is refused before there is memory for it; ``n_received``
    counts bytes, also of frames that are not complete.
    """

    def __init__(self, connection: socket.socket, max_bytes: int = MAX_BYTES) -> None:
        self.max_bytes = max_bytes
        self.n_received = 0
        self._socket = connection
        connection.settimeout(0.0)
        self._unsent: list[memoryview] = []
        self._kept = memoryview(b"")
        self._data, self._at, self._reads_length = self._room(_LENGTH.size), 0, True

    @property
    def is_sending(self) -> bool:
        """Whether a part of a frame is not sent yet."""
        return bool(self._unsent)

    def fileno(self) -> int:
        """Return the descriptor, for a poll."""
        return self._socket.fileno()

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def send(self, frame: Frame) -> None:
        """Send a frame as far as the other side takes it; raises OSError if that is gone."""
        pieces = _packed(frame)
        if sum(map(len, pieces)) <= _JOINED_BYTES:
            pieces = [b"".join(pieces)]
        self._unsent += map(memoryview, pieces)
        self.send_more()

    def send_more(self) -> None:
        """Send what is left, as far as the other side takes it; raises OSError if that is gone."""
        with suppress(BlockingIOError):
            _send_pieces(self._socket, self._unsent)

    def receive(self) -> Frame | None:
        """Return the next frame if all of it is there, else None; raises what `receive` raises."""
        with suppress(BlockingIOError):
            while True:
                self._read()
                data, was_length = self._data, self._reads_length
                n_bytes = _n_bytes(data, self.max_bytes) if was_length else _LENGTH.size
                frame = None if was_length else _unpacked(data, bytes)
                self._data, self._at, self._reads_length = self._room(n_bytes), 0, not was_length
                if frame is not None:
                    return frame
        return None

    def _read(self) -> None:
        """Read all of what is expected; raises BlockingIOError where some of it is not there yet."""
        while self._at < len(self._data):
            n_more = self._socket.recv_into(self._data[self._at :])
            if not n_more:
                raise EOFError
            self._at += n_more
            self.n_received += n_more

    def _room(self, n_bytes: int) -> memoryview:
        """Return memory for what is read next: the same again, if it is not large."""
        if n_bytes > _WARM_BYTES:
            return memoryview(bytearray(n_bytes))
        if n_bytes > len(self._kept):
            self._kept = memoryview(bytearray(n_bytes))
        return self._kept[:n_bytes]


def _n_bytes(data: memoryview, max_bytes: int) -> int:
    (n_bytes,) = _LENGTH.unpack(data)
    if not _HEADER.size <= n_bytes <= max_bytes:
        raise ValueError(f"a frame of {n_bytes} bytes, expected {_HEADER.size} to {max_bytes}")
    return int(n_bytes)


def _unpacked(data: memoryview, kept: Callable[[memoryview], Any]) -> Frame:
    """Return a frame; ``kept`` makes its messages from their places in ``data``."""
    n_bytes = len(data)
    kind, n_head, n_messages = _HEADER.unpack_from(data)
    at = _HEADER.size + n_messages * _SIZE.size
    if at + n_head > n_bytes:
        raise ValueError(f"a frame of {n_bytes} bytes that says it holds {at + n_head} or more")
    try:
        head = _DECODE(str(data[at : at + n_head], "utf-8"))
    except RecursionError as error:
        raise ValueError("a frame that is nested too deeply") from error
    at += n_head
    messages = []
    for k in range(n_messages):
        (size,) = _SIZE.unpack_from(data, _HEADER.size + k * _SIZE.size)
        messages.append(kept(data[at : at + size]))
        at += size
    if at != n_bytes:
        raise ValueError(f"a frame of {n_bytes} bytes that says it holds {at}")
    return Frame(kind, head, tuple(messages))


def _packed(frame: Frame) -> Sequence[bytes]:
    head = _ENCODE(frame.head).encode()
    sizes = struct.pack(f"<{len(frame.messages)}I", *map(len, frame.messages))
    header = _HEADER.pack(frame.kind, len(head), len(frame.messages)) + sizes + head
    n_bytes = len(header) + sum(map(len, frame.messages))
    if n_bytes > MAX_BYTES:
        raise ValueError(f"a frame of {n_bytes} bytes, at most {MAX_BYTES} can be sent to another process")
    return [_LENGTH.pack(n_bytes) + header, *frame.messages]


def _send_pieces(link: socket.socket, pieces: list[memoryview]) -> None:
    while pieces:
        n_sent = link.sendmsg(pieces[:_MAX_PIECES])
        done = 0
        while done < len(pieces) and n_sent >= len(pieces[done]):
            n_sent -= len(pieces[done])
            done += 1
        del pieces[:done]
        if n_sent:
            pieces[0] = pieces[0][n_sent:]


def _received(link: socket.socket, n_bytes: int) -> memoryview:
    """Wait for so many bytes; they come as one piece, unless a signal or a time limit of the socket interferes."""
    pieces: list[bytes] = []
    while n_bytes:
        pieces.append(link.recv(n_bytes, socket.MSG_WAITALL))
        if not pieces[-1]:
            raise EOFError
        n_bytes -= len(pieces[-1])
    return memoryview(pieces[0] if len(pieces) == 1 else b"".join(pieces))
