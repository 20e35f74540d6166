"""A ROS 2 bag that is exported is read by the library of bags alone, and its numbers are those of the log."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from graphnav import CameraInfo, Goal, Image, LocalMap, Message, Odometry, Scan, State, Stop, Twist
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter, Recording
from graphnav.core.record.bags.bag_writer import topic_of

STORE = get_typestore(Stores.ROS2_HUMBLE)
UTIME = 1_700_000_000_123_457


def read(folder: Path) -> dict[str, list[tuple[int, Any]]]:
    """Return the times (ns) and messages of each topic, by a distribution of ROS 2 that robots have."""
    found: dict[str, list[tuple[int, Any]]] = {}
    with Reader(folder) as reader:
        for connection, logged_ns, data in reader.messages():
            message = STORE.deserialize_cdr(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((logged_ns, message))
    return found


def stamp_us(message: Any) -> float:
    return float(message.header.stamp.sec * 1_000_000 + message.header.stamp.nanosec / 1000)


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_drive_has_the_numbers_of_its_log(drive: Path, tmp_path: Path, storage: str, capsys: Any) -> None:
    target = tmp_path / "bag"
    assert main(["export", str(drive), "--to", "rosbag2", "--storage", storage, "-o", str(target)]) == 0
    shown = capsys.readouterr()
    assert shown.out.startswith(f"{target}: 124 messages of 6 channels, ")
    left_out = (
        "10 channels have no standard ROS type, left out: robot.map (Map), robot.limits (BaseLimits), robot.motion"
    )
    assert shown.err.startswith(left_out)
    assert len(shown.err.splitlines()) == 1
    assert sorted(file.name for file in target.iterdir()) == [
        "bag.mcap" if storage == "mcap" else "bag.db3",
        "metadata.yaml",
    ]
    topics = read(target)
    with Recording(drive / "run.lcmlog") as log:
        for (utime, _, image), (logged_ns, ros) in zip(
            log.messages("robot.image"), topics["/robot/image"], strict=True
        ):
            assert isinstance(image, Image)
            assert (logged_ns, stamp_us(ros)) == (utime * 1000, utime)
            assert (ros.encoding, ros.step, ros.header.frame_id) == ("mono8", 160, "camera")
            np.testing.assert_array_equal(ros.data.reshape(ros.height, ros.width), image.pixels)
        for (utime, _, state), (_, ros) in zip(log.messages("robot.state"), topics["/robot/state"], strict=True):
            assert isinstance(state, State)
            pose, turn = ros.pose.pose.position, ros.pose.pose.orientation
            assert (stamp_us(ros), ros.header.frame_id, ros.child_frame_id) == (utime, "map", "base_link")
            assert (pose.x, pose.y, ros.twist.twist.linear.x) == (state.x_m, state.y_m, state.v_mps)
            assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(math.remainder(state.yaw_rad, math.tau), abs=1e-15)
        for (utime, _, twist), (_, ros) in zip(log.messages("guard.twist"), topics["/guard/twist"], strict=True):
            assert isinstance(twist, Twist)
            assert stamp_us(ros) == utime
            assert (ros.twist.linear.x, ros.twist.angular.z) == (twist.v_mps, twist.omega_radps)
    assert {type(ros).__name__ for _, ros in topics["/steer/steering"]} == {"std_msgs__msg__Float64"}


def write(path: Path, *messages: Message) -> Path:
    with LogWriter(path) as log:
        for number, message in enumerate(messages):
            log.write(f"a.{type(message).__name__.lower()}", UTIME + 5, encode(message, UTIME, number))
    return path


def test_every_type_that_ros_has(tmp_path: Path) -> None:
    state = np.array([[0, 1, 2], [3, 1, 1]], np.uint8)
    grid = LocalMap(0.25, -1.0, 2.0, -1.0, 2.0, 0.5, state)
    ranges = np.array([1.0, math.inf, 0.5], np.float32)
    info = CameraInfo(
        120, 160, "plumb_bob", np.diag([114.0, 115.0, 1.0]), np.arange(5.0), np.eye(3), np.arange(12.0).reshape(3, 4)
    )
    log = write(
        tmp_path / "drive.lcmlog",
        Image(np.arange(18, dtype=np.uint8).reshape(2, 3, 3)),
        Odometry(1.0, 2.0, -0.5, 0.3, 0.1),
        grid,
        Scan(-0.5, 0.25, 0.1, 9.0, ranges),
        Goal(bearing_rad=math.pi / 2, distance_m=2.0),
        Stop(engaged=True, reason="a person"),
        info,
    )
    assert main(["export", str(log), "--to", "rosbag2", "-o", str(tmp_path / "bag")]) == 0
    found = {topic: messages[0][1] for topic, messages in read(tmp_path / "bag").items()}
    assert {logged_ns for messages in read(tmp_path / "bag").values() for logged_ns, _ in messages} == {
        1000 * (UTIME + 5)
    }
    assert (found["/a/image"].encoding, found["/a/image"].data.tolist()) == ("rgb8", list(range(18)))
    assert stamp_us(found["/a/odometry"]) == UTIME
    ros = found["/a/localmap"]
    assert (ros.info.width, ros.info.height, ros.info.resolution) == (3, 2, 0.25)
    assert (ros.info.origin.position.x, ros.info.origin.position.y) == (-1.125, 1.875)
    assert ros.data.tolist() == [-1, 0, 100, 100, 0, 0]
    ros = found["/a/scan"]
    np.testing.assert_array_equal(ros.ranges, ranges)
    assert (ros.angle_min, ros.angle_max, ros.angle_increment) == (-0.5, 0.0, 0.25)
    assert found["/a/goal"].point.y == 2.0
    assert found["/a/stop"].data is True
    ros = found["/a/camerainfo"]
    assert (ros.height, ros.width, ros.distortion_model) == (120, 160, "plumb_bob")
    assert (ros.k[0], ros.p.tolist(), ros.d.tolist()) == (114.0, list(range(12)), list(range(5)))
    with Recording(tmp_path / "bag") as bag:
        back = bag.message("/a/camerainfo", 0)[2]
    assert isinstance(back, CameraInfo)
    assert all(map(np.array_equal, vars(back).values(), vars(info).values()))


def test_names_that_ros_does_not_have() -> None:
    assert topic_of("robot.image", []) == "/robot/image"
    assert topic_of("/camera/image_raw", []) == "/camera/image_raw"
    assert topic_of("CAMERA (left)", []) == "/CAMERA__left_"
    assert topic_of("robot//2nd.image/", []) == "/robot_/_2nd/image"
    assert topic_of("a-b", ["/a_b"]) == "/a_b_"
    assert topic_of("", []) == "/_"


def test_times_and_numbers_that_ros_does_not_have(tmp_path: Path, capsys: Any) -> None:
    log = write(tmp_path / "drive.lcmlog", Twist(0.5, 0.0), Scan(-0.5, 0.25, 0.1, 1e300, np.ones(3, np.float32)))
    with LogWriter(tmp_path / "late.lcmlog") as late, Recording(log) as recording:
        for event in recording.events():
            late.write(event.channel, event.utime, event.data)
        late.write("a.twist", 1 << 60, encode(Twist(0.5, 0.0), 1 << 60, 9))
        late.write("a.twist", 5, encode(Twist(0.5, 0.0), -5, 9))
    assert main(["export", str(tmp_path / "late.lcmlog"), "--to", "rosbag2", "-o", str(tmp_path / "bag")]) == 0
    assert {topic: len(messages) for topic, messages in read(tmp_path / "bag").items()} == {"/a/twist": 1}
    assert capsys.readouterr().err == (
        "channel 'a.scan': 1 messages left out: their ROS type cannot hold their numbers or times\n"
        "channel 'a.twist': 2 messages left out: their ROS type cannot hold their numbers or times\n"
    )


def test_what_cannot_be_exported(drive: Path, tmp_path: Path, capsys: Any) -> None:
    words = ["export", str(drive), "--to", "rosbag2"]
    assert main([*words, "--channel", "flow.flow", "-o", str(tmp_path / "bag")]) == 2
    assert capsys.readouterr().err == (
        f"nothing to export from {drive}/run.lcmlog: no selected channel has a standard ROS type\n"
        "  select other channels with --channel, or export to csv or mcap\n"
    )
    (tmp_path / "bag").write_text("a file")
    assert main([*words, "-o", str(tmp_path / "bag")]) == 2
    assert capsys.readouterr().err.startswith(f"{tmp_path}/bag is a file\n")
    assert (tmp_path / "bag").read_text() == "a file"


def test_a_bag_is_a_log_for_other_commands(drive: Path, tmp_path: Path, capsys: Any) -> None:
    bag = tmp_path / "bag"
    assert main(["export", str(drive), "--to", "rosbag2", "-o", str(bag)]) == 0
    capsys.readouterr()
    assert main(["info", str(bag)]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith(f"{bag}: ")
    assert " 124 messages on 6 channels, 2.000 s\n" in shown
    for line in (
        "/robot/image     image_t ",
        "/robot/state     odometry_t ",
        "/robot/goal      geometry_msgs/msg/PointStamped ",
    ):
        assert line in shown
    assert shown.endswith("no damage\n")
    assert main(["hz", "/robot/image", str(bag)]) == 0
    assert "10.00" in capsys.readouterr().out
    assert main(["echo", "/guard/twist", str(bag), "-n", "1"]) == 0
    assert "omega_radps" in capsys.readouterr().out
    assert main(["spy", str(bag)]) == 0
    assert "/robot/state  graphnav_lcm.odometry_t, 10.00 Hz" in capsys.readouterr().out
    assert main(["export", str(bag), "--to", "images", "-o", str(tmp_path / "frames")]) == 0
    assert len(list((tmp_path / "frames").iterdir())) == 21
    assert main(["replay", str(bag)]) == 2
    capsys.readouterr()
