"""Frames in the pipe from a run to the process that sends its motor channels."""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import NamedTuple

MAX_PAYLOAD_BYTES = 1 << 20
"""The largest command; a longer frame is not accepted."""

READY, FAILED = b"+", b"-"
"""Replies of the process after its set-up; the reason of a failure follows."""

_HEADER = struct.Struct("=IBHd")


class Kind(IntEnum):
    """The kind of a frame."""

    SETUP = 0
    """The channels, as JSON; the first frame."""
    COMMAND = 1
    """Forward the payload."""
    STOP = 2
    """Stop for one second and go on."""
    END = 3
    """Stop for one second and end."""


class Frame(NamedTuple):
    """A frame: ``channel`` is an index into the channels of the set-up, ``sent_s`` the monotonic time of sending."""

    kind: int
    channel: int
    sent_s: float
    payload: bytes


def pack(kind: Kind, channel: int, sent_s: float, payload: bytes = b"") -> bytes:
    """Return the bytes of a frame; writing up to ``PIPE_BUF`` bytes to a pipe is atomic."""
    return _HEADER.pack(len(payload), kind, channel, sent_s) + payload


class FrameReader:
    """Splits the byte stream of the pipe into frames; keeps an incomplete one until the rest arrives."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def feed(self, data: bytes) -> list[Frame]:
        """Return the frames that ``data`` completes; raises ValueError for a frame above `MAX_PAYLOAD_BYTES`."""
        self._bytes += data
        frames: list[Frame] = []
        start = 0
        while len(self._bytes) - start >= _HEADER.size:
            n_bytes, kind, channel, sent_s = _HEADER.unpack_from(self._bytes, start)
            if n_bytes > MAX_PAYLOAD_BYTES:
                raise ValueError(f"a frame of {n_bytes} bytes, expected at most {MAX_PAYLOAD_BYTES}")
            body = start + _HEADER.size
            if len(self._bytes) < body + n_bytes:
                break
            start = body + n_bytes
            frames.append(Frame(kind, channel, sent_s, bytes(self._bytes[body:start])))
        del self._bytes[:start]
        return frames
