"""The networks of the motor channels, each opened only where a channel needs it."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack

from graphnav.core.bus import Bus
from graphnav.core.dds import Ros2Node
from graphnav.core.ros2 import Ros2Network, RosType
from graphnav.live.motors.channel import MotorChannel
from graphnav.live.motors.motor import Publishes

WHO = "a motor output with ros2"


class MotorLinks:
    """LCM and ROS 2 for some motor channels; ``node``: the participant to use, None to open one.

    Raises BusError if a network cannot be opened, UserError if Cyclone DDS is not installed.
    """

    def __init__(self, url: str, channels: Sequence[MotorChannel], node: Ros2Node | None = None) -> None:
        self._bus: Bus | None = None
        self._node = node
        with ExitStack() as opened:
            for channel in channels:
                if (topic := channel.topic) is None:
                    if self._bus is None:
                        self._bus = Bus(url)
                        opened.callback(self._bus.close)
                    continue
                if self._node is None:
                    self._node = Ros2Node(Ros2Network(topic.domain, topic.interface), WHO)
                    opened.callback(self._node.close)
                self._node.offer(channel.name, RosType(topic.type_name, topic.definition))
            self._opened = opened.pop_all()

    def of(self, channel: MotorChannel) -> Publishes:
        """Return what sends a channel."""
        link = self._bus if channel.topic is None else self._node
        assert link is not None, "opened for it"
        return link

    def close(self) -> None:
        """Leave the networks that were opened here."""
        self._opened.close()
