"""Write ROS 2 bags by their own library, as another program would."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from graphnav.arrays import Bytes

STORE = get_typestore(Stores.ROS2_HUMBLE)
COMPRESSIONS = {"message": CompressionMode.MESSAGE, "chunk": CompressionMode.STORAGE, "file": CompressionMode.FILE}


class Sent(NamedTuple):
    """A message on a topic: a ROS message, or its bytes; recorded ``after_us`` its stamp."""

    topic: str
    message: Any
    stamp_us: int
    after_us: int = 0
    raw: bytes | None = None


def make(ros_type: str, **fields: Any) -> Any:
    """Return a ROS message of a type without ``msg``, as ``std_msgs/Bool``."""
    package, name = ros_type.split("/")
    return STORE.types[f"{package}/msg/{name}"](**fields)


def header(stamp_us: int) -> Any:
    seconds, rest_us = divmod(stamp_us, 1_000_000)
    return make(
        "std_msgs/Header", stamp=make("builtin_interfaces/Time", sec=seconds, nanosec=rest_us * 1000), frame_id="x"
    )


def image(pixels: Bytes, encoding: str, stamp_us: int = 0, padding: int = 0, **fields: Any) -> Any:
    """Return an image; ``padding``: bytes at the end of each row."""
    rows, cols = pixels.shape[:2]
    data = np.pad(pixels.reshape(rows, -1), ((0, 0), (0, padding)))
    given = {"height": rows, "width": cols, "step": data.shape[1], "data": data.reshape(-1), "is_bigendian": 0}
    return make("sensor_msgs/Image", header=header(stamp_us), encoding=encoding, **(given | fields))


def compressed(data: bytes, kind: str, stamp_us: int = 0) -> Any:
    array = np.frombuffer(data, np.uint8)
    return make("sensor_msgs/CompressedImage", header=header(stamp_us), format=kind, data=array)


def twist(v_mps: float, omega_radps: float) -> Any:
    def vector(x: float, z: float) -> Any:
        return make("geometry_msgs/Vector3", x=x, y=0.0, z=z)

    return make("geometry_msgs/Twist", linear=vector(v_mps, 0.0), angular=vector(0.0, omega_radps))


def odometry(pose: tuple[float, float, float], stamp_us: int, turn: tuple[float, ...] | None = None) -> Any:
    """Return odometry at a pose (x, y, yaw) that drives at 0.3 m/s; ``turn``: a quaternion x, y, z, w in its place."""
    x, y, z, w = turn or (0.0, 0.0, math.sin(pose[2] / 2), math.cos(pose[2] / 2))
    orientation = make("geometry_msgs/Quaternion", x=x, y=y, z=z, w=w)
    position = make("geometry_msgs/Point", x=pose[0], y=pose[1], z=0.5)
    zeros = np.zeros(36)
    return make(
        "nav_msgs/Odometry",
        header=header(stamp_us),
        child_frame_id="base_link",
        pose=make(
            "geometry_msgs/PoseWithCovariance",
            pose=make("geometry_msgs/Pose", position=position, orientation=orientation),
            covariance=zeros,
        ),
        twist=make("geometry_msgs/TwistWithCovariance", twist=twist(0.3, 0.1), covariance=zeros),
    )


def write_bag(
    folder: Path,
    sent: Iterable[Sent],
    storage: str = "mcap",
    compression: str = "",
    silent: Iterable[tuple[str, str]] = (),
    *,
    little_endian: bool = True,
) -> Path:
    """Write a bag; ``silent``: topics without messages, with their types. Return the folder."""
    writer = Writer(folder, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if compression:
        writer.set_compression(COMPRESSIONS[compression], CompressionFormat.ZSTD)
    with writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=STORE) for topic, kind in silent}
        for one in sent:
            kind = one.message.__msgtype__
            if one.topic not in connections:
                connections[one.topic] = writer.add_connection(one.topic, kind, typestore=STORE)
            data = one.raw or bytes(STORE.serialize_cdr(one.message, kind, little_endian=little_endian))
            writer.write(connections[one.topic], (one.stamp_us + one.after_us) * 1000, data)
    return folder


def file_of(folder: Path) -> Path:
    """Return the only file of a bag beside its metadata."""
    (found,) = (file for file in folder.iterdir() if file.name != "metadata.yaml")
    return found
