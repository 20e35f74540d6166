"""Stop messages of a motor channel that continue the stamps and sequence numbers of its commands."""

from __future__ import annotations

import struct
import time

from graphnav.live.motors.channel import INT64_BYTES, MotorChannel

_INT64 = struct.Struct(">q")
_HEADER_STAMP = struct.Struct("<iI")


def _wall_us() -> int:
    return time.time_ns() // 1000


class StopMessage:
    """Builds the stops of one channel and renumbers the commands that pass.

    A stop's stamp is that of the newest command plus the time since it was sent, in the clock that stamps the commands;
    before the first command it is wall time. The sequence number on the wire counts commands and stops together:
    that of a command is raised by the number of stops before it.
    """

    def __init__(self, channel: MotorChannel) -> None:
        self._stop = bytearray(channel.stop)
        self._stamp_at, self._seq_at = channel.stamp_at, channel.seq_at
        self._is_topic = channel.topic is not None
        self._stamp: tuple[int, float] | None = None
        self._seq = -1
        self._n_stops = 0

    def forward(self, data: bytes, sent_s: float) -> bytes:
        """Return a command, sent at the monotonic time ``sent_s`` (seconds), as it is forwarded."""
        if (at := self._stamp_at) is not None and len(data) >= at + INT64_BYTES:
            self._stamp = self._stamp_in(data, at), sent_s
        if (at := self._seq_at) is not None and len(data) >= at + INT64_BYTES:
            self._seq = _wrapped(_INT64.unpack_from(data, at)[0] + self._n_stops)
            if self._n_stops:
                return data[:at] + _INT64.pack(self._seq) + data[at + INT64_BYTES :]
        return data

    def stop(self, now_s: float) -> bytes:
        """Return the next stop at the monotonic time ``now_s`` (seconds)."""
        if self._stamp_at is not None:
            stamp, sent_s = self._stamp or (_wall_us(), now_s)
            self._put_stamp(self._stamp_at, _wrapped(stamp + round((now_s - sent_s) * 1e6)))
        if self._seq_at is not None:
            self._n_stops += 1
            self._seq = _wrapped(self._seq + 1)
            _INT64.pack_into(self._stop, self._seq_at, self._seq)
        return bytes(self._stop)

    def _stamp_in(self, data: bytes, at: int) -> int:
        if self._is_topic:
            sec, nanosec = _HEADER_STAMP.unpack_from(data, at)
            return int(sec) * 1_000_000 + int(nanosec) // 1000
        return int(_INT64.unpack_from(data, at)[0])

    def _put_stamp(self, at: int, utime: int) -> None:
        if self._is_topic:
            sec, us = divmod(utime, 1_000_000)
            _HEADER_STAMP.pack_into(self._stop, at, (sec + 2**31) % 2**32 - 2**31, us * 1000)
        else:
            _INT64.pack_into(self._stop, at, utime)


def _wrapped(value: int) -> int:
    """Return an integer wrapped to a signed 64-bit value."""
    return (value + 2**63) % 2**64 - 2**63
