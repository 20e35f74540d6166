"""Send an output of a live run to other programs and measure its latency."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Protocol

from graphnav import Message
from graphnav.core.bus import Bus
from graphnav.core.dds import Ros2Node
from graphnav.core.errors import BusError, one_line
from graphnav.core.graph import OutputChannel, stop_fields
from graphnav.core.interrupts import CtrlC
from graphnav.core.ros2 import STAMP_AT, Ros2Network
from graphnav.core.runner import Durations, Encoded
from graphnav.live.clock import LiveClock
from graphnav.live.motors.channel import MotorChannel, MotorTopic
from graphnav.live.motors.offsets import offsets_of


class Send(Protocol):
    """A function that sends encoded messages on a channel."""

    def __call__(self, channel: str, data: bytes, made_s: float) -> bool:
        """Send a message, decided at the monotonic time ``made_s``; return whether it was accepted."""


class Outlet:
    """Encodes the messages of one output in its LCM type and sends them.

    ``overtaken``: by channel, how many messages that ``send`` accepted were not sent, because newer ones were pending.
    """

    def __init__(
        self, target: OutputChannel, clock: LiveClock, send: Send, overtaken: Mapping[str, int] | None = None
    ) -> None:
        self.target = target
        self.refused = 0
        self.latency = Durations()
        """Durations from the birth of the input that a message derives from to its publication."""
        self.max_latency_s = 0.0
        self._clock, self._send = clock, send
        self._accepted = 0
        self._overtaken = {} if overtaken is None else overtaken

    @property
    def overtaken(self) -> int:
        """The number of messages that were not sent, because newer ones were pending."""
        return self._overtaken.get(self.target.name, 0)

    @property
    def sent(self) -> int:
        """The number of messages sent, or about to be."""
        return self._accepted - self.overtaken

    def publish(self, message: Message | Encoded, data: bytes, utime: int, birth_s: float, origin_s: float) -> None:
        """Send a message, which is not `Encoded` for an adapter.

        ``data``: its bytes in graphnav's own type; ``birth_s``, ``origin_s``: see `LiveInbox`.

        Raises
        ------
        ValueError
            The adapter cannot convert it to its type.
        """
        if self.target.adapter is not None:
            assert isinstance(message, Message), "decoded for it"
            data = adapted(self.target, message, utime)
        if not self._send(self.target.name, data, birth_s):
            self.refused += 1
            return
        self._accepted += 1
        latency_s = self._clock.now_s() - origin_s
        if math.isfinite(latency_s):
            self.latency.add(latency_s)
            self.max_latency_s = max(self.max_latency_s, latency_s)


def adapted(target: OutputChannel, message: Message, utime: int) -> bytes:
    """Return a message encoded in the type of an output."""
    assert target.adapter is not None
    try:
        return target.codec.encode(target.adapter.write(message, utime))
    except CtrlC:
        raise
    except BaseException as error:
        raise ValueError(f"{type(target.adapter).__name__}: {one_line(error)}") from error


def motor_channel(target: OutputChannel, network: Ros2Network) -> MotorChannel:
    """Return the motor channel of an output, for the sending process; ``network``: that of ROS 2 topics."""
    stop = target.codec.encode(stop_fields(target, target.stop))
    if (kind := target.ros_type) is not None:
        topic = MotorTopic(kind.name, kind.definition, network.domain or 0, network.interface)
        stamp_at = STAMP_AT if kind.is_stamped else None
        return MotorChannel(target.name, stop, stamp_at, None, target.max_age_s, topic)
    stamp_at, seq_at = offsets_of(target.lcm_class)
    return MotorChannel(target.name, stop, stamp_at, seq_at, target.max_age_s)


def bus_send(bus: Bus, notice: Callable[[str], None]) -> Send:
    """Return a function that sends on a bus without waiting; refused messages are counted, and reported once."""
    return _reporting(lambda channel, data: bus.send(channel, data, newest_only=True), notice)


def topic_send(node: Ros2Node, notice: Callable[[str], None]) -> Send:
    """Return a function that publishes topics without waiting; refused messages are counted, and reported once."""
    return _reporting(node.publish, notice)


def _reporting(publish: Callable[[str, bytes], None], notice: Callable[[str], None]) -> Send:
    told = False

    def send(channel: str, data: bytes, made_s: float) -> bool:  # noqa: ARG001
        nonlocal told
        try:
            publish(channel, data)
        except BusError as error:
            if not told:
                told = True
                notice(str(error))
            return False
        return True

    return send
