"""See which programs send on a channel, by the source addresses of their packets.

LCM does not tell its subscribers where a message comes from. A second socket in the group does; the kernel hands it the
first packets of the channels that are watched, cut after their header.
"""

from __future__ import annotations

import math
import os
import socket
import struct
import threading
import time
from collections.abc import Collection, Sequence
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

from graphnav.core.errors import shown_name
from graphnav.core.machine import keep_channels

_POLL_S = 0.1
_REST_S = 0.0005
"""A rest after each packet: of a flood some are enough."""
_LOOKUP_S = 0.25
"""Minimum time between two searches for processes, which take milliseconds: each message may be from another one."""
_NOTED_S = 0.005
"""The packet of a message is noted at most this long before the message arrives."""
_HEAD_BYTES = 128
_MAX_SOURCES = 16
"""Maximum number of sources that are kept for a channel; the one that has been silent longest is dropped."""
_MAGIC = struct.Struct(">I")
_UNFRAGMENTED, _FRAGMENTED = 0x4C433032, 0x4C433033
_NAME_AT = {_UNFRAGMENTED: 8, _FRAGMENTED: 20}
"""Where the name of the channel begins: LC02, and the first packet of LC03."""
_FRAGMENT_NUMBER_AT = slice(16, 18)

Source = tuple[str, int, int]
"""Address, port, and the kind of packet: a program may send large messages from another socket."""


class PacketSources:
    """Watches the sources of some channels of a URL in a thread; without the permission to listen it knows none."""

    def __init__(self, url: str, channels: Collection[str]) -> None:
        self._channels = frozenset(channels)
        self._heard: dict[str, dict[Source, float]] = {channel: {} for channel in channels}
        self._processes: dict[tuple[str, int], str] = {}
        self._lookup_s = 0.0
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="graphnav-packet-sources", daemon=True)
        self._socket: socket.socket | None = None
        with suppress(OSError):
            self._socket = _joined(url, self._channels)
            self._thread.start()

    def close(self) -> None:
        """Stop watching."""
        self._ending.set()
        if self._socket is not None:
            self._thread.join()
            self._socket.close()

    def sender(self, channel: str, since_s: float, at_s: float) -> str:
        """Return the program that sent the message that arrived at ``at_s``, the only one since ``since_s``, else "".

        It is not known either where the packet of the message has not been noted yet.
        """
        writers = self.writers(channel, since_s)
        is_noted = max(tuple(self._heard[channel].values()), default=-math.inf) >= at_s - _NOTED_S
        return writers[0] if len(writers) == 1 and is_noted else ""

    def writers(self, channel: str, since_s: float) -> Sequence[str]:
        """Return the programs that sent on a channel since a time, monotonic seconds: address, and process if local."""
        recent = [source for source, at_s in tuple(self._heard[channel].items()) if at_s >= since_s]
        longest = max(([one for one in recent if one[2] == kind] for kind in _NAME_AT), key=len)
        return [f"{host}:{port}{self._processes.get((host, port), '')}" for host, port, _ in sorted(longest)]

    def _serve(self) -> None:
        assert self._socket is not None
        while not self._ending.is_set():
            try:
                data, (host, port) = self._socket.recvfrom(_HEAD_BYTES)
            except TimeoutError:
                continue
            except OSError:
                self._ending.wait(_POLL_S)
                continue
            self._note(data, host, port)
            time.sleep(_REST_S)

    def _note(self, data: bytes, host: str, port: int) -> None:
        kind = int.from_bytes(data[: _MAGIC.size], "big")
        if kind not in _NAME_AT or (kind == _FRAGMENTED and any(data[_FRAGMENT_NUMBER_AT])):
            return
        name = data[_NAME_AT[kind] :].partition(b"\0")[0].decode("utf-8", "replace")
        if name not in self._channels:
            return
        heard, at_s = self._heard[name], time.monotonic()
        addresses = {source[:2] for source in heard} | {(host, port)}
        if len(addresses) > 1 and at_s >= self._lookup_s and (unknown := addresses - self._processes.keys()):
            self._processes |= _processes_of(unknown)
            self._lookup_s = time.monotonic() + _LOOKUP_S
        heard[host, port, kind] = at_s
        if len(heard) > _MAX_SOURCES:
            silent = min(heard, key=lambda source: heard[source])
            del heard[silent]
            self._processes.pop(silent[:2], None)


def _joined(url: str, channels: Collection[str]) -> socket.socket:
    """Return a socket in the group of a URL that gets the packets of some channels only; raises OSError."""
    parts = urlsplit(url)
    group, port = parts.hostname or "", parts.port or 0
    joined = socket.socket(socket.AF_INET, socket.SOCK_DGRAM, socket.IPPROTO_UDP)
    try:
        joined.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        keep_channels(joined, sorted(channels), _HEAD_BYTES)
        joined.bind((group, port))
        member = struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton("0.0.0.0"))  # noqa: S104 - all interfaces
        joined.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
        joined.settimeout(_POLL_S)
    except OSError:
        joined.close()
        raise
    return joined


def _processes_of(addresses: Collection[tuple[str, int]]) -> dict[tuple[str, int], str]:
    """Return the processes that send from addresses of this machine, as additions to them; empty if not known."""
    found = dict.fromkeys(addresses, "")
    links: dict[str, tuple[str, int]] = {}
    with suppress(OSError):
        rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
        for host, port in filter(_is_local, addresses):
            links |= {
                f"socket:[{row[9]}]": (host, port) for row in rows if len(row) > 9 and row[1].endswith(f":{port:04X}")
            }
    for process in Path("/proc").glob("[0-9]*") if links else ():
        with suppress(OSError):  # of another user, or ended
            for one in (process / "fd").iterdir():
                if (address := links.get(os.readlink(one))) is not None:
                    found[address] = f" (pid {process.name}, {shown_name((process / 'comm').read_text().strip())})"
    return found


def _is_local(address: tuple[str, int]) -> bool:
    with suppress(OSError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind((address[0], 0))
        return True
    return False
