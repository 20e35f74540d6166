"""One end of a tunnel: messages of the group to the link, and those of the link to the group."""

from __future__ import annotations

import math
import os
import select
import time
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from enum import IntEnum
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from graphnav.core.bus import Bus
from graphnav.core.errors import BusError
from graphnav.core.large_messages import PACKET_BYTES
from graphnav.processes.frames import Frame
from graphnav.processes.host_link import HostLink, LinkError, Refusal
from graphnav.processes.tunnel.choice import Choice
from graphnav.processes.tunnel.motor_channels import MotorChannels
from graphnav.processes.tunnel.outbox import Accounts, Outbox, Passed

_BURST_BYTES, _REST_S = 65_536, 0.001
"""A rest for receivers with a stock buffer, which holds three packets, after so many bytes at once."""
_FRAMES_AT_ONCE = 8
"""So many frames are read before anything else is done."""
_TELL_S = 1.0
_MAX_TOLD = 200
_MAX_NAME_BYTES = 63
_MAX_COUNT = 1 << 62
_BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
_NETWORK = Path("/proc/self/ns/net")
_LOST = ("dropped", "thinned", "held")
"""Numbers that an end tells of the messages that it does not send."""


class Kind(IntEnum):
    """The kinds of frames of a tunnel."""

    CHOICE = 16
    """First of all: the channels that an end takes, and its group, None for that of one process."""
    MESSAGES = 17
    """Messages, and in the head their channels."""
    LOST = 18
    """Messages that were not sent since the last such frame, by channel: numbers of `_LOST`."""


class Ways(NamedTuple):
    """The channels that an end takes, and those that it gives."""

    taken: Choice
    given: Choice


class TunnelEnd:
    """An end of a tunnel to one other host; ``link`` is proven.

    ``bus``: of the group, one that forwards. ``motors``: what is known of this group's motor channels, which pass only
    if the end that takes them names them. ``came``, ``left``, ``lost``: messages by channel that were given to the
    group, sent, and, as the other end told, not sent to this one.
    """

    def __init__(self, link: HostLink, bus: Bus, ways: Ways, motors: MotorChannels) -> None:
        self.link = link
        self.came, self.left, self.lost = Accounts(), Accounts(), Accounts()
        self._bus, self._ways, self._motors = bus, ways, motors
        self._wanted: Choice | None = None
        self._moves_nothing = False
        """Whether the other end's group is that of one process, which only shows what it takes."""
        self._outbox = Outbox(self.left)
        self._arrived: deque[tuple[str, bytes]] = deque()
        self._rest_until_s = self._due_s = -math.inf
        self._tell_s = time.monotonic() + _TELL_S
        self._told: dict[str, tuple[int, ...]] = {}
        self._group = group_of(bus.url)
        link.send(Frame(Kind.CHOICE, {"takes": ways.taken.as_told, "group": self._group}))

    def hear(self, channel: str, data: bytes, now_s: float) -> None:
        """Take a message of the group, which leaves if both ends choose it."""
        wanted = self._wanted
        if wanted is None:
            return
        given_hz, wanted_hz = self._ways.given.limit_hz(channel), wanted.limit_hz(channel)
        if given_hz is None or wanted_hz is None:
            return
        if not self._moves_nothing and self._motors.has(channel, data) and not wanted.names(channel):
            self.left.of(channel).held += 1
            return
        self._outbox.put(channel, data, min(given_hz, wanted_hz), now_s)

    def events(self) -> int:
        """Return the events of the link that this end waits for."""
        reads = 0 if self._arrived else select.POLLIN
        return reads | (select.POLLOUT if self.link.is_sending else 0)

    def due_s(self) -> float:
        """Return when to serve this end again, whatever happens; infinite for never."""
        return min(self._due_s, self._rest_until_s if self._arrived else math.inf)

    def serve(self) -> None:
        """Receive and send as far as nothing has to wait; raises LinkError where the link is lost."""
        now_s = time.monotonic()
        self._give(now_s)
        for _ in range(_FRAMES_AT_ONCE):
            if self._arrived or (frame := self.link.receive()) is None:
                break
            self._take(frame)
            self._give(now_s)
        self.link.send_more()
        self._due_s = self._outbox.release(now_s)
        while not self.link.is_sending and self._outbox.has_more:
            channels, messages = self._outbox.take(now_s)
            self.link.send(Frame(Kind.MESSAGES, channels, tuple(messages)))
        if now_s >= self._tell_s and not self.link.is_sending:
            self._tell_s = now_s + _TELL_S
            self._tell()
        self.link.tick(now_s)

    def close(self) -> None:
        """Close the link; what waits is counted as dropped."""
        self._outbox.drop_all()
        for channel, _ in self._arrived:
            self.came.of(channel).dropped += 1
        self._arrived.clear()
        self.link.close()

    def _take(self, frame: Frame) -> None:
        """Handle a frame of the other end; raises LinkError for what is none."""
        try:
            is_known = self._handle(frame)
        except ValueError as error:
            raise LinkError(f"{self.link.peer} sent {error}", Refusal.FOREIGN) from error
        if not is_known:
            raise LinkError(f"{self.link.peer} sent a frame that is not of a tunnel", Refusal.FOREIGN)

    def _handle(self, frame: Frame) -> bool:
        """Handle a frame; return whether it is one of a tunnel. Raises ValueError for what it holds."""
        match frame:
            case Frame(Kind.MESSAGES, list(channels), messages) if len(channels) == len(messages):
                self._arrived.extend(zip(channels, messages, strict=True))
            case Frame(Kind.LOST, dict(lost)):
                self._add_lost(lost)
            case Frame(Kind.CHOICE, {"takes": takes, "group": group}) if self._wanted is None:
                if group is not None and group == self._group:
                    what = f"both ends are in the group {urlsplit(self._bus.url).netloc} of this machine"
                    raise LinkError(what, Refusal.SERVICE)
                self._wanted = Choice.told(takes)
                self._moves_nothing = group is None
            case _:
                return False
        return True

    def _give(self, now_s: float) -> None:
        """Give what has arrived to the group, with rests."""
        n_bytes = 0
        while self._arrived and now_s >= self._rest_until_s:
            channel, data = self._arrived.popleft()
            if not isinstance(channel, str):
                raise LinkError(f"{self.link.peer} sent a channel without a name", Refusal.FOREIGN)
            if not self._publish(channel, data):
                continue
            n_bytes += len(data) if len(data) < PACKET_BYTES else 0
            if n_bytes >= _BURST_BYTES:
                n_bytes, self._rest_until_s = 0, time.monotonic() + _REST_S

    def _publish(self, channel: str, data: bytes) -> bool:
        """Give a message to the group if this end has chosen it; return whether it was."""
        account = self.came.of(channel)
        taken = self._ways.taken
        if taken.limit_hz(channel) is None or not is_name(channel):
            account.refused += 1
        elif self._motors.is_announced(channel) and not taken.names(channel):
            account.held += 1
        else:
            try:
                self._bus.send(channel, data, newest_only=True)
            except BusError:
                account.refused += 1
                return False
            account.passed += 1
            account.n_bytes += len(data)
            return True
        return False

    def _tell(self) -> None:
        """Tell the other end what was not sent to it."""
        news: dict[str, list[int]] = {}
        for channel, passed in self.left.channels.items():
            now = tuple(getattr(passed, name) for name in _LOST)
            before = self._told.get(channel, (0,) * len(_LOST))
            if now != before and len(news) < _MAX_TOLD:
                self._told[channel] = now
                news[channel] = [a - b for a, b in zip(now, before, strict=True)]
        if news:
            self.link.send(Frame(Kind.LOST, news))

    def _add_lost(self, lost: Mapping[Any, Any]) -> None:
        for channel, numbers in lost.items():
            match numbers:
                case [int() as dropped, int() as thinned, int() as held] if all(0 <= n < _MAX_COUNT for n in numbers):
                    self.lost.of(channel).add(Passed(dropped=dropped, thinned=thinned, held=held))
                case _:
                    raise ValueError("something else than numbers of messages")


def is_name(channel: str) -> bool:
    """Whether LCM takes the name of a channel, and a log does."""
    try:
        return 0 < len(channel.encode("utf-8", "surrogateescape")) <= _MAX_NAME_BYTES and "\0" not in channel
    except UnicodeEncodeError:
        return False


def group_of(url: str) -> list[str] | None:
    """Return what tells a group of a machine from all others: its boot, its network namespace, address and port.

    It is None for ``memq://``, which no other program hears.
    """
    if url.startswith("memq:"):
        return None
    boot, network = "", ""
    with suppress(OSError):
        boot, network = _BOOT_ID.read_text(encoding="ascii").strip(), os.readlink(_NETWORK)
    return [boot, network, urlsplit(url).netloc]
