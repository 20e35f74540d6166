"""The tap: copies of a run's messages for other programs on this machine."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Literal

from graphnav.core.bus import Bus, fits_packet
from graphnav.core.codec import decode, encode, message_class_of, type_named
from graphnav.core.errors import GraphnavError, shown_name
from graphnav.core.large_messages.child import PACKET_BYTES
from graphnav.core.lcm_url import tap_url
from graphnav.core.machine.system import is_linux
from graphnav.core.messages import About, Message
from graphnav.core.notices import print_notice
from graphnav.core.record.recording import Recording

_PICTURES_HZ = 32
"""A camera of 30 Hz loses none; a run at full speed makes five times as many, which no eye takes."""
_BURST_PICTURES = 16
"""So many more at once: what a short delay has held up."""
_STAMP = slice(8, 16)
"""Of a message: its first field, after the fingerprint."""
_MAX_STEP_PX = 64
_MAX_QUEUED_BYTES = 8 << 20
_PER_MESSAGE_BYTES = 256
_GATHER_S = 0.005
"""Messages within this time wake the thread once: each wake takes the interpreter from the run."""
_BURST_BYTES = 65_536
_BURST_MESSAGES = 16
_PAUSE_S = 0.002
"""The pause after a burst: default receive buffers hold three packets, default queues 30 messages."""
_ABOUT_S = 1.0
_CLOSE_TIMEOUT_S = 0.3
_MAX_TOLD = 8
"""Further runs are not reported: any program can announce runs under names of its choice."""
_MAX_ID = 60
"""Longer names of runs are cut in notices."""


class Tap:
    """Publishes copies of a run's messages on UDP multicast from a separate thread.

    It never blocks or fails the run: ``write`` appends to a bounded queue that drops rather than waits, and failures
    are counted in ``dropped``. A message that is the only one on its channel is repeated every second, like
    ``graphnav.about``, for late subscribers. In mode "thin" grids larger than one packet are sent with every n-th row
    and column, and messages from 4 kB on of at most 32 stamps a second of wall time: those of one stamp are sent
    together, so that a picture is seen with what was made from it. "full" sends all bytes. What is larger than a packet
    leaves with gaps (`Bus.send`), the newest of a channel if they come faster than that.

    ``notice`` is called once for each other run on the same group that publishes the same channels, for at most 8 runs,
    and once for all further ones. Raises BusError if there is no multicast route.
    """

    def __init__(
        self,
        mode: Literal["thin", "full"],
        run_id: str,
        url: str,
        notice: Callable[[str], None] = print_notice,
    ) -> None:
        self.dropped = 0
        self.url = Bus.with_defaults(url)
        Bus.require_route(self.url)
        self._mode, self._run_id, self._notice = mode, run_id, notice
        self._about: About | None = None
        self._shareable: frozenset[str] = frozenset()
        self._classes: dict[str, type[Message] | None] = {}
        self._steps: dict[tuple[str, int], int] = {}
        self._told: set[str] = set()
        self._spoken: set[str] = set()
        self._lone: dict[str, tuple[float, bytes]] = {}
        self._waiting: deque[tuple[str, int, bytes]] = deque()
        self._put_bytes = self._taken_bytes = 0
        self._shown = b""
        self._picture_due_s: dict[str, float] = {}
        self._dropping = threading.Lock()
        self._closing, self._wake = threading.Event(), threading.Event()
        self._is_idle = False
        self._utime = self._n_abouts = self._overtaken = 0
        self._about_due_s = 0.0
        bus = Bus(self.url, notice)
        bus.subscribe(About.CHANNEL, self._receive)
        self._thread = threading.Thread(target=self._serve, args=(bus,), name="graphnav-tap", daemon=True)
        self._thread.start()

    def announce(self, about: About, shareable: Collection[str] = ()) -> None:
        """Publish the description of the run on ``graphnav.about``, now and every second.

        ``shareable``: channels that other runs may also have, such as outputs of one run that another one reads.
        """
        self._shareable = frozenset(shareable)
        types = zip(about.channels, map(type_named, about.types), strict=True)
        self._classes = {channel: lcm_class and message_class_of(lcm_class) for channel, lcm_class in types}
        self._about = replace(about, run_id=self._run_id)
        self._wake.set()

    def write(self, channel: str, utime: int, data: bytes) -> None:
        """Queue a message, or drop it; returns immediately."""
        n_bytes = len(data) + _PER_MESSAGE_BYTES
        is_left_out = self._mode == "thin" and len(data) >= Recording.SMALL_BYTES and not self._is_shown(channel, data)
        if is_left_out or self._put_bytes - self._taken_bytes + n_bytes > _MAX_QUEUED_BYTES:
            self._drop()
            return
        self._put_bytes += n_bytes
        self._waiting.append((channel, utime, data))
        if self._is_idle:
            self._is_idle = False
            self._wake.set()

    def _is_shown(self, channel: str, data: bytes) -> bool:
        """Whether a large message is sent: its stamp is shown, or becomes so because its channel is due."""
        now_s, stamp = time.monotonic(), data[_STAMP]
        due_s = self._picture_due_s.get(channel, 0.0)
        if stamp != self._shown and now_s < due_s - _BURST_PICTURES / _PICTURES_HZ:
            return False
        self._shown = stamp
        self._picture_due_s[channel] = max(now_s, due_s) + 1 / _PICTURES_HZ
        return True

    def close(self) -> None:
        """Send the queued messages, for at most a third of a second, and stop."""
        self._closing.set()
        self._wake.set()
        self._thread.join()

    def _serve(self, bus: Bus) -> None:
        """Publish until closed; from here on only this thread uses ``bus``."""
        burst_bytes = burst_messages = 0
        stop_s = math.inf
        while time.monotonic() < stop_s:
            if self._closing.is_set() and stop_s == math.inf:
                stop_s = time.monotonic() + _CLOSE_TIMEOUT_S
            self._announce_again(bus)
            if not burst_messages or not self._waiting:  # rarely: a call of LCM may take the interpreter from the run
                bus.drain()
            if self._waiting:
                channel, self._utime, data = self._waiting.popleft()
                self._taken_bytes += len(data) + _PER_MESSAGE_BYTES
                self._remember(channel, data)
                burst_bytes += self._send(bus, channel, data)
                burst_messages += 1
                if burst_bytes >= _BURST_BYTES or burst_messages >= _BURST_MESSAGES:
                    burst_bytes = burst_messages = 0
                    time.sleep(_PAUSE_S)
            elif self._closing.is_set():
                break
            else:
                self._rest()
        bus.close()
        self._drop(len(self._waiting) + sum(bus.overtaken.values()) - self._overtaken)

    def _rest(self) -> None:
        """Wait for messages, at most until the description is due; then for those that come with them."""
        self._wake.clear()
        self._is_idle = True
        if not self._waiting and not self._closing.is_set():
            self._wake.wait(_ABOUT_S if self._about is None else max(0.0, self._about_due_s - time.monotonic()))
        self._is_idle = False
        if self._waiting:
            self._closing.wait(_GATHER_S)

    def _announce_again(self, bus: Bus) -> None:
        """Repeat the description, and messages published once (the map), after a second."""
        if self._about is not None and time.monotonic() >= self._about_due_s:
            self._about_due_s = time.monotonic() + _ABOUT_S
            self._send(bus, About.CHANNEL, encode(self._about, self._utime, self._n_abouts))
            self._n_abouts += 1
            for channel, (said_s, data) in self._lone.items():
                if time.monotonic() - said_s > _ABOUT_S:
                    self._send(bus, channel, data)

    def _remember(self, channel: str, data: bytes) -> None:
        """Keep the message of a channel while it is the only one."""
        if channel in self._spoken:
            self._lone.pop(channel, None)
        else:
            self._spoken.add(channel)
            self._lone[channel] = time.monotonic(), data

    def _send(self, bus: Bus, channel: str, data: bytes) -> int:
        """Send a message, thinned if necessary; return the number of bytes that left at once."""
        try:
            if self._mode == "thin" and not fits_packet(channel, data):
                data = self._thinned(channel, data)
            bus.send(channel, data, newest_only=True)
        except (GraphnavError, TypeError, ValueError, AttributeError, IndexError):
            self._drop()
            return 0
        overtaken = sum(bus.overtaken.values())
        if overtaken > self._overtaken:
            self._drop(overtaken - self._overtaken)
            self._overtaken = overtaken
        return len(data) if fits_packet(channel, data) else 0

    def _thinned(self, channel: str, data: bytes) -> bytes:
        """Return the message thinned to fit one packet; unchanged if it has no grid."""
        message_class = self._classes.get(channel)
        if message_class is None or not message_class.grid:
            return data
        utime, seq, message = decode(message_class, data)
        kind = (channel, len(data))
        for step in range(self._steps.get(kind) or math.isqrt(len(data) // PACKET_BYTES) + 1, _MAX_STEP_PX):
            thinned = encode(message.thin(step), utime, seq)
            if fits_packet(channel, thinned):
                self._steps[kind] = step
                return thinned
        return data

    def _receive(self, _channel: str, data: bytes) -> None:
        """Report other runs on this group that publish on the same channels."""
        if self._about is None or len(self._told) > _MAX_TOLD:
            return
        try:
            other = decode(About, data)[2]
        except GraphnavError:
            return
        shared = sorted(set(other.channels) & set(self._about.channels) - self._shareable)
        if not shared or other.run_id in self._told | {self._run_id}:
            return
        self._told.add(other.run_id)
        if len(self._told) > _MAX_TOLD:
            self._notice(
                f"more than {_MAX_TOLD} other runs publish the channels of run {self._run_id} on {self.url}: "
                "further ones are not reported"
            )
            return
        self._notice(
            f"run {self._run_id} and run {_cut(shown_name(other.run_id))} both publish {', '.join(shared[:3])} "
            f"on {self.url}: a viewer sees both mixed\n  give one of them --no-tap"
        )

    def _drop(self, count: int = 1) -> None:
        with self._dropping:
            self.dropped += count


def _cut(name: str) -> str:
    return name if len(name) <= _MAX_ID else f"{name[:_MAX_ID]}…"


def open_tap(
    mode: Literal["thin", "full", "none"],
    run_id: str,
    *,
    tell: Callable[[str], None],
    notice: Callable[[str], None] | None = None,
) -> Tap | None:
    """Return the tap of a run, or None if it is off, multicast is lacking, or this is not Linux.

    ``tell`` gets the reason if there is none; ``notice``, by default the same, gets notices of other runs on its group.
    """
    if mode == "none":
        return None
    if not is_linux():
        tell("no tap: other programs can read the channels of a run on Linux only")
        return None
    try:
        return Tap(mode, run_id, tap_url(), notice or tell)
    except GraphnavError as error:
        tell(f"no tap: {error}")
        return None
