"""A filter in the kernel that keeps from liblcm the packets on which it crashes.

In an unfragmented message liblcm 1.5 searches for the end of the channel's name beyond the end of the packet. If the
packet has no such end the size of the message becomes negative, which crashes the receiving process.
"""

from __future__ import annotations

import ctypes
import os
import socket
import stat
import struct
from contextlib import suppress
from typing import NamedTuple

_UNFRAGMENTED = 0x4C433032
"""The magic number of an unfragmented message: LC02."""
_UDP_HEADER_BYTES, _LCM_HEADER_BYTES, _NAME_BYTES = 8, 8, 64
_SO_ATTACH_FILTER = 26
_LOAD_WORD, _LOAD_BYTE, _LOAD_LENGTH, _IF_EQUAL, _IF_AT_LEAST, _RETURN = 0x20, 0x30, 0x80, 0x15, 0x35, 0x06
_ACCEPT = 0x7FFFFFFF


class _Step(NamedTuple):
    """An instruction of a classic BPF program; a load beyond the end of the packet drops the packet."""

    code: int
    value: int
    skip_if: int = 0
    skip_else: int = 0


def filter_packets(port: int) -> int:
    """Attach the filter to the UDP sockets of this process that are bound to ``port``; return their number."""
    program = _program()
    packed = (struct.pack("HBBI", step.code, step.skip_if, step.skip_else, step.value) for step in program)
    steps = ctypes.create_string_buffer(b"".join(packed))
    option = struct.pack("HP", len(program), ctypes.addressof(steps))
    count = 0
    for name in os.listdir("/proc/self/fd"):
        with suppress(OSError):  # another thread closed it
            count += _filter_socket(int(name), port, option)
    return count


def _filter_socket(number: int, port: int, option: bytes) -> bool:
    if not stat.S_ISSOCK(os.fstat(number).st_mode):
        return False
    with socket.socket(fileno=os.dup(number)) as found:
        if (found.family, found.type) != (socket.AF_INET, socket.SOCK_DGRAM) or found.getsockname()[1] != port:
            return False
        found.setsockopt(socket.SOL_SOCKET, _SO_ATTACH_FILTER, option)
        return True


def _program() -> list[_Step]:
    """Return the filter: it drops unfragmented messages whose channel name is neither terminated nor too long.

    LCM itself refuses longer names and packets shorter than its header; dropped packets would count as lost.
    """
    begin = _UDP_HEADER_BYTES + _LCM_HEADER_BYTES
    steps = [_Step(_LOAD_LENGTH, 0), _Step(_IF_AT_LEAST, begin, 1, 0), _Step(_RETURN, _ACCEPT)]
    steps += [_Step(_LOAD_WORD, _UDP_HEADER_BYTES), _Step(_IF_EQUAL, _UNFRAGMENTED, 1, 0), _Step(_RETURN, _ACCEPT)]
    for k in range(_NAME_BYTES):
        to_accept = 2 * (_NAME_BYTES - 1 - k)
        steps += [_Step(_LOAD_BYTE, begin + k), _Step(_IF_EQUAL, 0, to_accept, 0)]
    return [*steps, _Step(_RETURN, _ACCEPT)]
