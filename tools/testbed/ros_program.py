"""The process of `testbed.ros_peer`: it codes messages by the library's own classes, so that it tests graphnav's."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections.abc import Mapping
from typing import Any

from cyclonedds._clayer import ddspy_write
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import make_idl_struct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import array, byte, float32, float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic


def types() -> dict[str, Any]:
    """Return the classes of the ROS types by name, as a user of Cyclone DDS writes them."""
    made: dict[str, Any] = {}

    def add(name: str, **fields: Any) -> Any:
        package, _, kind = name.partition("/")
        cls = make_idl_struct(f"{kind}_", f"{package}::msg::dds_::{kind}_", fields)
        made[name] = final(cls)
        return made[name]

    stamp = add("builtin_interfaces/Time", sec=int32, nanosec=uint32)
    head = add("std_msgs/Header", stamp=stamp, frame_id=str)
    add("std_msgs/Bool", data=bool)
    vector = add("geometry_msgs/Vector3", x=float64, y=float64, z=float64)
    point = add("geometry_msgs/Point", x=float64, y=float64, z=float64)
    quaternion = add("geometry_msgs/Quaternion", x=float64, y=float64, z=float64, w=float64)
    pose = add("geometry_msgs/Pose", position=point, orientation=quaternion)
    twist = add("geometry_msgs/Twist", linear=vector, angular=vector)
    add("geometry_msgs/TwistStamped", header=head, twist=twist)
    with_pose = add("geometry_msgs/PoseWithCovariance", pose=pose, covariance=array[float64, 36])
    with_twist = add("geometry_msgs/TwistWithCovariance", twist=twist, covariance=array[float64, 36])
    add("nav_msgs/Odometry", header=head, child_frame_id=str, pose=with_pose, twist=with_twist)
    image = {"height": uint32, "width": uint32, "encoding": str, "is_bigendian": byte, "step": uint32}
    add("sensor_msgs/Image", header=head, **image, data=sequence[byte])
    add("sensor_msgs/CompressedImage", header=head, format=str, data=sequence[byte])
    corner = {"x_offset": uint32, "y_offset": uint32, "height": uint32, "width": uint32}
    roi = add("sensor_msgs/RegionOfInterest", **corner, do_rectify=bool)
    lens = {"height": uint32, "width": uint32, "distortion_model": str, "d": sequence[float64]}
    lens |= {"k": array[float64, 9], "r": array[float64, 9], "p": array[float64, 12]}
    add("sensor_msgs/CameraInfo", header=head, **lens, binning_x=uint32, binning_y=uint32, roi=roi)
    meta = add(
        "nav_msgs/MapMetaData", map_load_time=stamp, resolution=float32, width=uint32, height=uint32, origin=pose
    )
    add("nav_msgs/OccupancyGrid", header=head, info=meta, data=sequence[byte])
    return made


def made(cls: Any, fields: Mapping[str, Any]) -> Any:
    """Return an object of a class from its fields as JSON has them."""
    values = {}
    for name, kind in cls.__annotations__.items():
        value = fields.get(name)
        if isinstance(kind, type) and hasattr(kind, "__idl__"):
            values[name] = made(kind, value or {})
        elif value is None:
            text = str(kind)
            values[name] = "" if kind is str else [0.0] * 36 if "36" in text else [] if "sequence" in text else 0
        elif name == "data" and isinstance(value, list) and len(value) == 2:
            values[name] = [value[1]] * value[0]
        else:
            values[name] = bool(value) if kind is bool else value
    return cls(**values)


def plain(value: Any) -> Any:
    """Return a received object as JSON has it."""
    if hasattr(type(value), "__idl__"):
        return {name: plain(getattr(value, name)) for name in type(value).__annotations__}
    if isinstance(value, bytes | bytearray | list | tuple):
        return [int(one) if isinstance(one, int) else float(one) for one in value]
    return value


class _Process:
    """The process's side."""

    def __init__(self, domain: int) -> None:
        self._participant = DomainParticipant(domain)
        self._types = types()
        self._writers: dict[str, list[Any]] = {}
        self._topics: dict[str, Any] = {}
        self._readers: dict[str, Any] = {}
        self._lock = threading.Lock()
        threading.Thread(target=self._serve, daemon=True).start()

    def obey(self, words: Mapping[str, Any]) -> None:
        """Do what a line says."""
        with self._lock:
            if "listen" in words:
                self._listen(words["listen"], words["kind"], latched=words["latched"])
            elif "offer" in words:
                self._offer(words["offer"], words["kind"], words["writers"])
            elif "say" in words:
                writer = self._writers[words["say"]][words["writer"]]
                writer.write(made(writer.data_type, words["fields"]))
            else:
                ddspy_write(self._writers[words["bytes"]][0]._ref, bytes.fromhex(words["hex"]))  # noqa: SLF001

    def _topic(self, name: str, kind: str) -> Any:
        return self._topics.setdefault(name, Topic(self._participant, f"rt{name}", self._types[kind]))

    def _listen(self, name: str, kind: str, *, latched: bool) -> None:
        durability = Policy.Durability.TransientLocal if latched else Policy.Durability.Volatile
        qos = Qos(Policy.Reliability.Reliable(100_000_000), Policy.History.KeepLast(500), durability)
        self._readers[name] = DataReader(self._participant, self._topic(name, kind), qos=qos)

    def _offer(self, name: str, kind: str, writers: int) -> None:
        qos = Qos(
            Policy.Reliability.Reliable(100_000_000),
            Policy.History.KeepLast(10),
            Policy.DataRepresentation(use_cdrv0_representation=True),
        )
        topic = self._topic(name, kind)
        self._writers[name] = [DataWriter(self._participant, topic, qos=qos) for _ in range(writers)]

    def _serve(self) -> None:
        while True:
            with self._lock:
                heard = [(name, one) for name, reader in self._readers.items() for one in reader.take(100)]
            for name, one in heard:
                if hasattr(type(one), "__idl__"):
                    sys.stdout.write(json.dumps({"topic": name, "fields": plain(one)}) + "\n")
            sys.stdout.flush()
            time.sleep(0.005)


if __name__ == "__main__":
    process = _Process(int(sys.argv[1]))
    for command in sys.stdin:
        process.obey(json.loads(command))
