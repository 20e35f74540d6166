"""Filters in the kernel: they keep packets from liblcm on which it crashes, and select the packets of channels.

In an unfragmented message liblcm 1.5 searches for the end of the channel's name beyond the end of the packet. If the
packet has no such end the size of the message becomes negative, which crashes the receiving process.
"""

from __future__ import annotations

import ctypes
import os
import socket
import stat
import struct
from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import NamedTuple

from graphnav.core.large_messages.child import FORWARDED

_UNFRAGMENTED = 0x4C433032
"""The magic number of an unfragmented message: LC02."""
_UDP_HEADER_BYTES, _LCM_HEADER_BYTES, _FRAGMENT_HEADER_BYTES, _NAME_BYTES = 8, 8, 20, 64
_NUMBER_AT = 12
"""Of the sequence number, in packets of either kind."""
_SO_ATTACH_FILTER, _SO_LOCK_FILTER = 26, 44
_LOAD_WORD, _LOAD_BYTE, _LOAD_LENGTH = 0x20, 0x30, 0x80
_IF_EQUAL, _IF_AT_LEAST, _JUMP, _RETURN = 0x15, 0x35, 0x05, 0x06
_ACCEPT = 0x7FFFFFFF


class _Step(NamedTuple):
    """An instruction of a classic BPF program; a load beyond the end of the packet drops the packet."""

    code: int
    value: int
    skip_if: int = 0
    skip_else: int = 0


def filter_packets(port: int) -> int:
    """Attach the filter to the UDP sockets of this process that are bound to ``port``; return their number."""
    return _filter_sockets(port, _program())


def ignore_forwarded(port: int, inodes: Collection[str]) -> int:
    """Let some UDP sockets of this process that are bound to ``port`` get no message that came from another host.

    The filter is also that of `filter_packets`, which cannot replace it. Return the number of the sockets.
    """
    return _filter_sockets(port, _program(_not_forwarded()), inodes)


def keep_channels(receiving: socket.socket, channels: Sequence[str], n_bytes: int) -> None:
    """Let a UDP socket get only the first packets of messages on some channels, cut to ``n_bytes``."""
    small, large = (_of_channels(channels, size, n_bytes) for size in (_LCM_HEADER_BYTES, _FRAGMENT_HEADER_BYTES))
    choice = [_Step(_LOAD_WORD, _UDP_HEADER_BYTES), _Step(_IF_EQUAL, _UNFRAGMENTED, 1, 0), _Step(_JUMP, len(small))]
    _attach(receiving, [*choice, *small, *large])
    receiving.setsockopt(socket.SOL_SOCKET, _SO_LOCK_FILTER, 1)  # filter_packets cannot replace it


def _of_channels(channels: Sequence[str], header_bytes: int, n_bytes: int) -> list[_Step]:
    """Return the steps that keep packets whose header is followed by the name of one of some channels."""
    steps: list[_Step] = []
    for channel in channels:
        name = channel.encode() + b"\0"
        begin, end = _UDP_HEADER_BYTES + header_bytes, 2 * len(name) + 1
        for k, char in enumerate(name):
            steps += [_Step(_LOAD_BYTE, begin + k), _Step(_IF_EQUAL, char, 0, end - 2 * (k + 1))]
        steps.append(_Step(_RETURN, _UDP_HEADER_BYTES + n_bytes))
    return [*steps, _Step(_RETURN, 0)]


def _attach(receiving: socket.socket, program: Sequence[_Step]) -> None:
    packed = (struct.pack("HBBI", step.code, step.skip_if, step.skip_else, step.value) for step in program)
    steps = ctypes.create_string_buffer(b"".join(packed))
    receiving.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, struct.pack("HP", len(program), ctypes.addressof(steps)))


def _filter_sockets(port: int, program: Sequence[_Step], inodes: Collection[str] | None = None) -> int:
    """Attach a program to sockets bound to a port, to those of ``inodes`` for good; return how many there were."""
    count = 0
    for name in os.listdir("/proc/self/fd"):
        with suppress(OSError):  # another thread closed it
            count += _filter_socket(int(name), port, program, inodes)
    return count


def _filter_socket(number: int, port: int, program: Sequence[_Step], inodes: Collection[str] | None) -> bool:
    status = os.fstat(number)
    if not stat.S_ISSOCK(status.st_mode) or (inodes is not None and str(status.st_ino) not in inodes):
        return False
    with socket.socket(fileno=os.dup(number)) as found:
        if (found.family, found.type) != (socket.AF_INET, socket.SOCK_DGRAM) or found.getsockname()[1] != port:
            return False
        _attach(found, program)
        if inodes is not None:
            found.setsockopt(socket.SOL_SOCKET, _SO_LOCK_FILTER, 1)
        return True


def _not_forwarded() -> list[_Step]:
    """Return the steps that cut packets by their number to less than a header: a dropped one would count as lost."""
    first, count = FORWARDED
    return [
        _Step(_LOAD_WORD, _NUMBER_AT),
        _Step(_IF_AT_LEAST, first, 0, 2),
        _Step(_IF_AT_LEAST, first + count, 1, 0),
        _Step(_RETURN, _NUMBER_AT),
    ]


def _program(more: Sequence[_Step] = ()) -> list[_Step]:
    """Return the filter: it drops unfragmented messages whose channel name is neither terminated nor too long.

    LCM itself refuses longer names and packets shorter than its header; dropped packets would count as lost. ``more``
    steps come before it, for packets of at least a header.
    """
    begin = _UDP_HEADER_BYTES + _LCM_HEADER_BYTES
    steps = [_Step(_LOAD_LENGTH, 0), _Step(_IF_AT_LEAST, begin, 1, 0), _Step(_RETURN, _ACCEPT), *more]
    steps += [_Step(_LOAD_WORD, _UDP_HEADER_BYTES), _Step(_IF_EQUAL, _UNFRAGMENTED, 1, 0), _Step(_RETURN, _ACCEPT)]
    for k in range(_NAME_BYTES):
        to_accept = 2 * (_NAME_BYTES - 1 - k)
        steps += [_Step(_LOAD_BYTE, begin + k), _Step(_IF_EQUAL, 0, to_accept, 0)]
    return [*steps, _Step(_RETURN, _ACCEPT)]
