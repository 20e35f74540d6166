"""The networks of the motor channels, each opened only where a channel needs it."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from graphnav.core.bus import Bus
from graphnav.live.motors.channel import MotorChannel, MotorTopic
from graphnav.live.motors.motor import Publishes

if TYPE_CHECKING:
    from graphnav.core.dds import Ros2Node

WHO = "a motor output with ros2"


class MotorLinks:
    """LCM and ROS 2 for some motor channels; ``node``: the participant to use, None to open one.

    Raises BusError if a network cannot be opened, UserError if Cyclone DDS is not installed.
    """

    def __init__(self, url: str, channels: Sequence[MotorChannel], node: Ros2Node | None = None) -> None:
        self._bus: Bus | None = None
        self._node = node
        with ExitStack() as opened:
            if not channels or any(channel.topic is None for channel in channels):
                self._bus = Bus(url)
                opened.callback(self._bus.close)
            for channel in channels:
                if channel.topic is not None:
                    self._offer(channel.name, channel.topic, opened)
            self._opened = opened.pop_all()

    def _offer(self, name: str, topic: MotorTopic, opened: ExitStack) -> None:
        """Open ROS 2 for a topic; only a run that has one imports what it takes, numpy among it."""
        from graphnav.core.dds import Ros2Node
        from graphnav.core.ros2 import Ros2Network, RosType

        if self._node is None:
            self._node = Ros2Node(Ros2Network(topic.domain, topic.interface), WHO)
            opened.callback(self._node.close)
        self._node.offer(name, RosType(topic.type_name, topic.definition))

    def of(self, channel: MotorChannel) -> Publishes:
        """Return what sends a channel."""
        link = self._bus if channel.topic is None else self._node
        assert link is not None, "opened for it"
        return link

    def close(self) -> None:
        """Leave the networks that were opened here."""
        self._opened.close()
