"""One motor channel in the process that sends it."""

from __future__ import annotations

import math
from typing import Protocol

from graphnav.core.errors import BusError
from graphnav.live.motors.channel import MotorChannel
from graphnav.live.motors.schedule import StopSchedule
from graphnav.live.motors.stop_message import StopMessage


class Publishes(Protocol):
    """Sends messages, by LCM or ROS 2."""

    def publish(self, channel: str, data: bytes, /) -> None:
        """Send a message at once; raises BusError if it is not taken."""


class Motor:
    """Forwards the commands of a channel and sends its stops; all times are monotonic seconds.

    Messages that the network refuses are counted in ``failed`` and not repeated: the next command or stop follows soon.
    """

    def __init__(self, channel: MotorChannel, link: Publishes) -> None:
        self.forwarded = self.stops = self.failed = self.late = 0
        self._name, self._max_age_s = channel.name, channel.max_age_s
        self._link = link
        self._schedule = StopSchedule(channel.max_age_s)
        self._message = StopMessage(channel)
        self._resumed_s = -math.inf

    @property
    def due_s(self) -> float:
        """Time at which the next stop is due."""
        return self._schedule.due_s

    def is_late(self, sent_s: float, now_s: float) -> bool:
        """Return whether a command is older than ``max_age_s``, or was sent before the process was resumed."""
        return now_s - sent_s > self._max_age_s or sent_s < self._resumed_s

    def command(self, data: bytes, sent_s: float, now_s: float) -> None:
        """Forward a command, unless it is late."""
        if self.is_late(sent_s, now_s):
            self.late += 1
            return
        self._schedule.command(sent_s)
        self.forwarded += self._publish(self._message.forward(data, sent_s))

    def resume(self, n_late: int, now_s: float) -> None:
        """Stop, and forward only what is sent from now on: ``n_late`` commands were not read in time.

        This process was suspended or starved: what was decided meanwhile belongs to a robot that did not obey.
        """
        self.late += n_late
        self._resumed_s = now_s
        self.order_stops(now_s)

    def order_stops(self, now_s: float) -> None:
        """Send a stop, and repeat it for one second."""
        self._schedule.order(now_s)
        self.stop_if_due(now_s)

    def stop_if_due(self, now_s: float) -> None:
        """Send a stop if one is due."""
        if self._schedule.take(now_s):
            self.stops += self._publish(self._message.stop(now_s))

    def _publish(self, data: bytes) -> bool:
        try:
            self._link.publish(self._name, data)
        except BusError:
            self.failed += 1
            return False
        return True
