"""Frames between a run and its processes: their length first, then what is meant as JSON, then messages as they are."""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Sequence
from enum import IntEnum
from typing import Any, NamedTuple

MAX_BYTES = 1 << 30
"""The largest frame; a longer one is not accepted."""

_LENGTH = struct.Struct("=I")
_HEADER = struct.Struct("=BII")
_SIZE = struct.Struct("=I")
_JOINED_BYTES = 1 << 16
"""Smaller frames are copied into one piece, which costs less than a list of pieces."""
_MAX_PIECES = 512


class Kind(IntEnum):
    """The kind of a frame. The run asks, and the process answers each frame in turn."""

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


class Frame(NamedTuple):
    """A frame: ``head`` is what JSON holds, ``messages`` are encoded."""

    kind: int
    head: Any
    messages: tuple[bytes, ...] = ()


def send(link: socket.socket, frame: Frame) -> None:
    """Send a frame; raises OSError if the other side is gone."""
    pieces = _packed(frame)
    if sum(map(len, pieces)) <= _JOINED_BYTES:
        link.sendall(b"".join(pieces))
    else:
        _send_pieces(link, [memoryview(piece) for piece in pieces])


def receive(link: socket.socket) -> Frame:
    """Wait for a frame.

    Raises
    ------
    EOFError
        The other side is gone.
    OSError
        The same, while it was sending.
    ValueError
        It sent something else.
    """
    (n_bytes,) = _LENGTH.unpack(_received(link, _LENGTH.size))
    if not _HEADER.size <= n_bytes <= MAX_BYTES:
        raise ValueError(f"a frame of {n_bytes} bytes, expected {_HEADER.size} to {MAX_BYTES}")
    data = _received(link, n_bytes)
    kind, n_head, n_messages = _HEADER.unpack_from(data)
    at = _HEADER.size + n_messages * _SIZE.size
    if at + n_head > n_bytes:
        raise ValueError(f"a frame of {n_bytes} bytes that says it holds {at + n_head} or more")
    head = json.loads(bytes(data[at : at + n_head]))
    at += n_head
    messages = []
    for k in range(n_messages):
        (size,) = _SIZE.unpack_from(data, _HEADER.size + k * _SIZE.size)
        messages.append(bytes(data[at : at + size]))
        at += size
    if at != n_bytes:
        raise ValueError(f"a frame of {n_bytes} bytes that says it holds {at}")
    return Frame(kind, head, tuple(messages))


def _packed(frame: Frame) -> Sequence[bytes]:
    head = json.dumps(frame.head, separators=(",", ":")).encode()
    sizes = struct.pack(f"={len(frame.messages)}I", *map(len, frame.messages))
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
    data = memoryview(bytearray(n_bytes))
    at = 0
    while at < n_bytes:
        n_more = link.recv_into(data[at:])
        if not n_more:
            raise EOFError
        at += n_more
    return data
