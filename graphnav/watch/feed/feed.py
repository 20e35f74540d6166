"""A source of messages: a live multicast group, another computer, or a log."""

from __future__ import annotations

import math
import os
import re
import time
from collections import deque
from collections.abc import Callable, Collection, Generator
from pathlib import Path
from typing import NamedTuple, Protocol

from graphnav import GraphnavError, Recording
from graphnav.core.bus import Bus
from graphnav.core.errors import shown_name
from graphnav.core.lcm_url import tap_url
from graphnav.core.machine import require_linux
from graphnav.core.record import find_log
from graphnav.core.rooms import in_room
from graphnav.watch.channel_account import Clock

_PATIENCE_S = 0.1
_AT_ONCE = 1000
"""The maximum number of messages before control is yielded, so that a busy feed can be interrupted."""
_MAX_WAITING = 50_000
"""Messages that LCM queues for a slow listener: bounds memory, whatever is sent."""


_HOST = re.compile(r"(?:\[([0-9A-Za-z:.%]+)\]|([^\s:/@\[\]]+)):([0-9]{4,5})?")
_NAMES = "name a run folder, a log, a udpm:// URL or a computer: robot.local:"
_MIN_PORT, _MAX_PORT = 1024, 65_535


class Received(NamedTuple):
    """A received message; ``at_s``: time of arrival or recording, on a clock of any origin."""

    channel: str
    data: bytes
    at_s: float


class _Group(Protocol):
    """The source of a live feed: a `Bus`, or the group of another computer."""

    def subscribe_all(self, handler: Callable[[str, bytes], None], max_waiting: int = 0, /) -> None: ...

    def handle(self, timeout_s: float) -> bool: ...

    def dropped_packets(self) -> int: ...

    def close(self) -> None: ...


class _FarGroup(_Group, Protocol):
    """The group of another computer, as `graphnav.processes` hears it."""

    name: str
    failure: str
    losses: str
    connected_for_s: float


class Feed:
    """A multicast group (``udpm://...``), another computer (`host_of`), a log, or a run folder.

    Without a name it is the group of the tap. Another computer is called until it answers, and again after a cut;
    ``channels``: those of which it has to send every message, None for all.

    Raises UserError if the name does not exist, ``LCM_DEFAULT_URL`` is not usable, or there is no key for another
    computer.
    """

    def __init__(self, name: str | None, channels: Collection[str] | None = None) -> None:
        self.name = name or tap_url()
        self._far: _FarGroup | None = None
        if (host := host_of(self.name)) is not None:
            require_linux("the feed of another computer works")
            self._far = in_room("processes.tunnel.far_group").FarGroup(*host, channels)
            self.name = self._far.name
        self.is_live = self._far is not None or self.name.startswith("udpm:")
        self.truncated = ""
        self.recording: Recording | None = None
        """The log if its user has opened it, else None; `open_log` hands it over."""
        self._bus: _Group | None = None
        self._dropped_packets = 0
        if not self.is_live:
            self.path = find_log(Path(self.name), _NAMES)

    @property
    def clock(self) -> Clock | None:
        """The arrival clock; None for a log."""
        return time.monotonic if self.is_live else None

    @property
    def epoch_s(self) -> float:
        """The wall time, seconds since 1970, at which the arrival clock was 0; 0 for a log."""
        return time.time() - time.monotonic() if self.is_live else 0.0

    def check(self) -> None:
        """Raise BusError early if a live feed cannot be opened."""
        if self._far is None:
            Bus.require_route(Bus.with_defaults(self.name))

    def open(self, take: Callable[[Received], None]) -> None:
        """Join a group, whose messages `handle` gives to ``take``; nothing happens if it is open already.

        Raises BusError if LCM cannot be opened, UserError if another computer refuses this one.
        """
        if self._bus is not None:
            return
        bus: _Group = self._far or Bus(self.name)
        bus.subscribe_all(lambda channel, data: take(Received(channel, data, time.monotonic())), _MAX_WAITING)
        self._bus = bus

    @property
    def failure(self) -> str:
        """Why nothing comes from another computer, empty while it is connected, and for any other feed."""
        return self._far.failure if self._far is not None else ""

    @property
    def connected_for_s(self) -> float:
        """How long another computer has been connected, 0 while it is not; infinite for any other feed."""
        return self._far.connected_for_s if self._far is not None else math.inf

    @property
    def losses(self) -> str:
        """A phrase about what another computer has dropped in place of sending it; empty if there is nothing."""
        return self._far.losses if self._far is not None else ""

    def handle(self, timeout_s: float) -> bool:
        """Wait for one message of the open group; return whether one arrived.

        Raises UserError as `open` does.
        """
        assert self._bus is not None
        return self._bus.handle(timeout_s)

    def close(self) -> None:
        """Leave the group; nothing happens if it is not open."""
        self.dropped_packets()
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.close()

    def open_log(self) -> Recording:
        """Return the log, which the caller closes; raises LogError if it cannot be read."""
        recording, self.recording = self.recording, None
        return recording or Recording(self.path)

    def listen(self, for_s: float | None) -> Generator[Received | None]:
        """Yield messages, for ``for_s`` seconds if live; yields None periodically while no messages arrive."""
        return self._live(for_s) if self.is_live else self._recorded()

    def dropped_packets(self) -> int:
        """Return the number of packets dropped by the kernel; 0 for a log."""
        if (bus := self._bus) is not None:
            self._dropped_packets = max(self._dropped_packets, bus.dropped_packets())
        return self._dropped_packets

    def silence(self, for_s: float | None, channel: str | None = None) -> GraphnavError:
        """Return the error for a feed, or a channel, without messages."""
        what = f"no message on channel '{shown_name(channel or '')}'"
        if not self.is_live:
            return GraphnavError(f"{what} in {self.name}" if channel else f"{self.name} is empty")
        what = f"{what} of {self.name}" if channel else f"no message on {self.name}"
        within = f" within {for_s:g} s" if for_s is not None else ""
        if self.failure:
            return GraphnavError(f"{what}{within}: {self.failure}")
        hint = "" if channel else "\n  start a run: graphnav run GRAPH --pace 1"
        return GraphnavError(what + within + hint)

    def _live(self, for_s: float | None) -> Generator[Received | None]:
        waiting: deque[Received] = deque()
        self.open(waiting.append)
        end_s = time.monotonic() + for_s if for_s is not None else None
        try:
            while (left_s := _PATIENCE_S if end_s is None else end_s - time.monotonic()) > 0:
                self.handle(min(left_s, _PATIENCE_S))
                while len(waiting) < _AT_ONCE and self.handle(0.0):
                    pass
                yield from waiting
                waiting.clear()
                yield None
        finally:
            self.close()

    def _recorded(self) -> Generator[Received | None]:
        with self.open_log() as recording:
            self.truncated = str(recording.truncated or "")
            for event in recording.events():
                yield Received(event.channel, event.data, event.utime / 1e6)


def drops_of(feed: Feed) -> str:
    """Return a phrase about packets dropped by the kernel, or messages by another computer; empty if there are none."""
    dropped = feed.dropped_packets()
    if not dropped:
        return feed.losses
    return f"{dropped} packet{'s' if dropped > 1 else ''} dropped by the kernel"


def host_of(name: str) -> tuple[str, int | None] | None:
    """Return host and port of ``HOST:``, ``HOST:PORT`` or ``[IPv6]:PORT``, the port None if it is not given.

    None for any other name and for a file or folder that exists. Ports begin at 1024, so that ``camera:0`` stays the
    name of a channel.
    """
    found = None if name.startswith("udpm:") else _HOST.fullmatch(name)
    if found is None or os.path.exists(name):
        return None
    port = None if found[3] is None else int(found[3])
    if port is not None and not _MIN_PORT <= port <= _MAX_PORT:
        return None
    return found[1] or found[2], port
