"""One output of a live run: what leaves for other programs, and how old it is by then."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from graphnav.bus import Bus
from graphnav.codec import codec_of
from graphnav.errors import BusError, one_line
from graphnav.graph import OutputChannel, stop_fields
from graphnav.live.clock import LiveClock
from graphnav.messages import Message
from graphnav.motors.channel import MotorChannel
from graphnav.motors.offsets import offsets_of
from graphnav.runner.durations import Durations


class Send(Protocol):
    """What takes the bytes of a channel."""

    def __call__(self, channel: str, data: bytes) -> bool:
        """Send; return whether they were taken."""


class Outlet:
    """Encodes the messages of one output for its type on the wire and sends them."""

    def __init__(self, target: OutputChannel, clock: LiveClock, send: Send) -> None:
        self.target = target
        self.sent = 0
        self.refused = 0
        self.latency = Durations()
        """From the stamp of the input that a message was made from to its publication."""
        self.max_latency_s = 0.0
        self._clock, self._send = clock, send

    def publish(self, message: Message, data: bytes, utime: int, origin_s: float) -> None:
        """Send a message; ``data``: its bytes in graphnav's own type; ``origin_s``: see `LiveUnit`.

        Raises
        ------
        ValueError
            The adapter cannot turn it into its type.
        """
        if self.target.adapter is not None:
            data = adapted(self.target, message, utime)
        if not self._send(self.target.name, data):
            self.refused += 1
            return
        self.sent += 1
        latency_s = self._clock.now_s() - origin_s
        if math.isfinite(latency_s):
            self.latency.add(latency_s)
            self.max_latency_s = max(self.max_latency_s, latency_s)


def adapted(target: OutputChannel, message: Message, utime: int) -> bytes:
    """Return the bytes of a message in the foreign type of an output."""
    assert target.adapter is not None
    try:
        return codec_of(target.lcm_class).encode(target.adapter.to_lcm(message, utime))
    except Exception as error:
        raise ValueError(f"{type(target.adapter).__name__}: {one_line(error)}") from error


def motor_channel(target: OutputChannel) -> MotorChannel:
    """Return what the process that sends a motor channel has to know."""
    stop = codec_of(target.lcm_class).encode(stop_fields(target, target.stop))
    stamp_at, seq_at = offsets_of(target.lcm_class)
    return MotorChannel(target.name, stop, stamp_at, seq_at, target.max_age_s)


def bus_send(bus: Bus, notice: Callable[[str], None]) -> Send:
    """Return what sends on a bus; a network that refuses is told once and counted, not fatal."""
    told = False

    def send(channel: str, data: bytes) -> bool:
        nonlocal told
        try:
            bus.publish(channel, data)
        except BusError as error:
            if not told:
                told = True
                notice(str(error))
            return False
        return True

    return send
