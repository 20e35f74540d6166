"""Put a robot that speaks LCM on ROS 2 topics: its camera is published, commands are taken; a process of its own.

usage: ros_bridge.py DOMAIN LCM_URL

Messages are coded by the classes of Cyclone DDS (`testbed.ros_program`), not by graphnav's.
"""

from __future__ import annotations

import sys
import time
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from graphnav import Image, Twist
from graphnav.core.bus import Bus
from graphnav.core.codec import decode, encode
from testbed.ros_peer import header
from testbed.ros_program import made, types

_POLL_S = 0.002


def main() -> None:
    """Pass messages on until the process is ended."""
    known, node, bus = types(), DomainParticipant(int(sys.argv[1])), Bus(sys.argv[2])
    image, twist = known["sensor_msgs/Image"], known["geometry_msgs/Twist"]
    best_effort = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
    writer: Any = DataWriter(node, Topic(node, "rt/camera/image_raw", image), qos=best_effort)
    reliable = Qos(Policy.Reliability.Reliable(100_000_000), Policy.History.KeepLast(10))
    reader: Any = DataReader(node, Topic(node, "rt/cmd_vel", twist), qos=reliable)

    def show(_channel: str, data: bytes) -> None:
        utime, _, picture = decode(Image, data)
        rows, cols = picture.pixels.shape
        fields = {"header": header(utime), "height": rows, "width": cols, "encoding": "mono8", "step": cols}
        message = made(image, fields)
        message.data = picture.pixels.reshape(-1).tolist()
        writer.write(message)

    bus.subscribe("CAMERA", show)
    seq = 0
    while True:
        bus.handle(_POLL_S)
        for command in reader.take(10):
            if isinstance(command, twist):
                moved = Twist(v_mps=command.linear.x, omega_radps=command.angular.z)
                bus.publish("BASE_CMD", encode(moved, time.time_ns() // 1000, seq))
                seq += 1


if __name__ == "__main__":
    main()
