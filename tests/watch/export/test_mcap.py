"""An mcap passes the reader of its own library, and its schemas explain every message."""

from __future__ import annotations

import io
import json
import math
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from PIL import Image as PillowImage

from graphnav import Image, Map, Odometry, Scan, State, Twist
from graphnav.core.cli import main
from graphnav.core.codec import encode
from graphnav.core.record import LogWriter, Recording


class Read(NamedTuple):
    """One message of an mcap: protobuf messages decoded, JSON checked by its schema."""

    topic: str
    schema: str
    log_time: int
    message: Any


def read(path: Path) -> list[Read]:
    """Return the messages of an mcap in the order of their times."""
    found = []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        factory = DecoderFactory()
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            if channel.message_encoding == "json":
                assert schema.encoding == "jsonschema"
                decoded = json.loads(message.data, parse_constant=pytest.fail)
                jsonschema.validate(decoded, json.loads(schema.data))
            else:
                decode = factory.decoder_for(channel.message_encoding, schema)
                assert decode is not None
                decoded = decode(message.data)
            found.append(Read(channel.topic, schema.name, message.log_time, decoded))
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(found)
    return found


@pytest.fixture(scope="module")
def exported(drive: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Read]:
    """Return what the mcap of the drive holds."""
    target = tmp_path_factory.mktemp("mcap") / "drive.mcap"
    assert main(["export", str(drive), "--to", "mcap", "-o", str(target)]) == 0
    return read(target)


def test_every_message_is_decoded_and_stamped_as_in_the_log(exported: list[Read], drive: Path) -> None:
    times = {message.log_time for message in exported}
    assert times <= {100_000_000 * k for k in range(21)}
    counts = Counter(message.topic for message in exported)
    with Recording(drive / "run.lcmlog") as recording:
        for name in ("control.twist", "plane.plane", "robot.state", "robot.image"):
            assert counts["/" + name.replace(".", "/")] == recording.count(name)
        assert counts["/robot/image/picture"] == recording.count("robot.image")
        assert counts["/plane/plane/picture"] == recording.count("plane.plane")
        assert counts["/flow/flow/picture"] == recording.count("flow.flow")
        assert counts["/scene/pose"] == recording.count("robot.state")


def test_the_schemas_are_those_that_foxglove_shows(exported: list[Read]) -> None:
    schemas = {message.topic: message.schema for message in exported}
    assert schemas["/robot/image/picture"] == "foxglove.CompressedImage"
    assert schemas["/scene/map"] == schemas["/scene/path"] == schemas["/scene/robot"] == "foxglove.SceneUpdate"
    assert schemas["/scene/pose"] == "foxglove.PoseInFrame"
    assert schemas["/tf"] == "foxglove.FrameTransform"
    assert schemas["/log"] == "foxglove.Log"
    assert schemas["/control/twist"] == "graphnav_lcm.twist_t"


def test_scalars_are_those_of_the_log(exported: list[Read], drive: Path) -> None:
    with Recording(drive / "run.lcmlog") as recording:
        steering = [message.message for message in exported if message.topic == "/steer/steering"]
        for index, found in enumerate(steering):
            fields = recording.fields("steer.steering", index)
            assert found["theta_rad"] == fields["theta_rad"]
            assert found["control"] == fields["control"].tolist()


def test_pictures_are_the_images_pixel_by_pixel(exported: list[Read], drive: Path) -> None:
    pictures = [message.message for message in exported if message.topic == "/robot/image/picture"]
    with Recording(drive / "run.lcmlog") as recording:
        for index, picture in enumerate(pictures):
            image = recording.message("robot.image", index)[2]
            assert isinstance(image, Image)
            assert picture.format == "png"
            assert np.array_equal(np.asarray(PillowImage.open(io.BytesIO(picture.data))), image.pixels)


def test_the_plane_is_drawn_over_its_image(exported: list[Read]) -> None:
    picture = next(message.message for message in exported if message.topic == "/plane/plane/picture")
    pixels = np.asarray(PillowImage.open(io.BytesIO(picture.data))).astype(int)
    assert pixels.shape == (120, 160, 3)
    assert pixels.std() > 5


def test_the_robot_moves_along_its_path_on_the_map(exported: list[Read], drive: Path) -> None:
    world = next(message.message for message in exported if message.topic == "/scene/map")
    assert {entity.frame_id for entity in world.entities} == {"world"}
    assert sum(len(entity.triangles) for entity in world.entities) >= 1
    poses = [message.message.pose for message in exported if message.topic == "/scene/pose"]
    with Recording(drive / "run.lcmlog") as recording:
        states = [state for _, _, state in recording.messages("robot.state") if isinstance(state, State)]
    assert [(pose.position.x, pose.position.y) for pose in poses] == [(s.x_m, s.y_m) for s in states]
    assert [2 * math.atan2(pose.orientation.z, pose.orientation.w) for pose in poses] == pytest.approx(
        [s.yaw_rad for s in states]
    )
    path = [message.message for message in exported if message.topic == "/scene/path"][-1]
    assert len(path.entities[0].lines[0].points) == len(states)


def test_the_log_tells_what_happened(exported: list[Read]) -> None:
    lines = [message.message.message for message in exported if message.topic == "/log"]
    assert lines[0].startswith("Follow the free floor around a counterclockwise bend")
    assert lines[0].endswith("(seed 7)")
    assert "outcome: timeout" in lines


def test_numbers_that_are_not_finite_are_left_out(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("WHEELS", 0, encode(Twist(v_mps=math.nan, omega_radps=1.0), 0, 0))
        log.write("POSE", 1, encode(Odometry(math.nan, 0.0, 0.0, 0.0, 0.0), 1, 0))
        log.write("POSE", 2, encode(Odometry(1.0, 2.0, 0.0, 0.0, math.inf), 2, 1))
    assert main(["export", str(tmp_path / "log"), "--to", "mcap", "-o", str(tmp_path / "a.mcap")]) == 0
    found = read(tmp_path / "a.mcap")
    assert next(m.message for m in found if m.topic == "/WHEELS") == {"utime": 0, "seq": 0, "omega_radps": 1.0}
    assert [m.message.pose.position.x for m in found if m.topic == "/scene/pose"] == [1.0]


def test_a_run_without_a_map_shows_its_odometry(tmp_path: Path) -> None:
    with LogWriter(tmp_path / "log") as log:
        for k in range(5):
            log.write("POSE", k, encode(Odometry(0.1 * k, 0.0, 0.0, 0.3, 0.0), k, k))
    assert main(["export", str(tmp_path / "log"), "--to", "mcap", "-o", str(tmp_path / "a.mcap")]) == 0
    topics = Counter(message.topic for message in read(tmp_path / "a.mcap"))
    assert topics == {"/POSE": 5, "/scene/pose": 5, "/tf": 5, "/scene/robot": 1, "/scene/path": 5}


def test_only_the_chosen_channels_are_there(drive: Path, tmp_path: Path) -> None:
    words = ["--channel", "plane.plane", "--from", "1s"]
    assert main(["export", str(drive), "--to", "mcap", "-o", str(tmp_path / "a.mcap"), *words]) == 0
    found = read(tmp_path / "a.mcap")
    assert {message.topic for message in found} == {"/plane/plane", "/plane/plane/picture", "/log"}
    assert min(message.log_time for message in found) == 10**9


@pytest.mark.parametrize("utime", [-1, -(2**63), 2**63 - 1, 2**32 * 10**6])
def test_stamps_that_no_viewer_can_show_are_counted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], utime: int
) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("WHEELS", 5, encode(Twist(v_mps=0.0, omega_radps=1.0), 5, 0))
        log.write("WHEELS", utime, encode(Twist(v_mps=0.0, omega_radps=1.0), 6, 1))
    assert main(["export", str(tmp_path / "log"), "--to", "mcap", "-o", str(tmp_path / "a.mcap")]) == 0
    assert "channel 'WHEELS': 1 message is left out: its timestamp is out of range" in capsys.readouterr().err
    assert sum(message.topic == "/WHEELS" for message in read(tmp_path / "a.mcap")) == 1


def test_a_map_of_any_numbers_is_survived(tmp_path: Path) -> None:
    nan = np.full((4, 2), np.nan)
    world = Map(
        kind=np.array([0, 7, 2], np.uint8),
        height_m=np.array([np.inf, 0.0, 1.0]),
        vertices_m=np.concatenate([nan, np.eye(4)[:, :2], np.eye(2)]),
        body=np.array([0] * 4 + [1] * 4 + [2] * 2, np.int32),
        start=np.zeros(3),
        goal_m=nan,
        robot_radius_m=math.nan,
        shortest_m=0.0,
        footprint_m=nan,
    )
    with LogWriter(tmp_path / "log") as log:
        log.write("map", 0, encode(world, 0, 0))
        moving = np.array([[math.nan, 0.0, 0.0], [1.0, 2.0, 3.0]])
        log.write("state", 1, encode(State(1.0, 2.0, 0.5, 0.0, 0.0, 0.1, True, False, moving), 1, 0))
    assert main(["export", str(tmp_path / "log"), "--to", "mcap", "-o", str(tmp_path / "a.mcap")]) == 0
    found = read(tmp_path / "a.mcap")
    assert next(len(m.message.entities) for m in found if m.topic == "/scene/map") == 1
    assert "contact" in [m.message.message for m in found if m.topic == "/log"]


@pytest.mark.parametrize("name", ["log", "/log", "tf", "scene.map", "twist", "a.b", "\x1b[31m<b>", "\n"])
def test_a_channel_may_be_called_as_a_topic_is(tmp_path: Path, name: str) -> None:
    with LogWriter(tmp_path / "log") as log:
        log.write("a/b/picture", 0, encode(Twist(v_mps=0.0, omega_radps=1.0), 0, 0))
        log.write("a.b", 0, encode(Image(np.zeros((2, 2), np.uint8)), 0, 0))
        log.write("state", 0, encode(State(1.0, 2.0, 0.5, 0.0, 0.0, 0.1, True, False, np.empty((0, 3))), 0, 0))
        log.write(name, 1, encode(Image(np.zeros((2, 2), np.uint8)), 1, 0))
    assert main(["export", str(tmp_path / "log"), "--to", "mcap", "-o", str(tmp_path / "a.mcap")]) == 0
    found = read(tmp_path / "a.mcap")
    assert all(len({m.schema for m in found if m.topic == topic}) == 1 for topic in {m.topic for m in found})
    assert all(m.topic.isprintable() for m in found)
    assert sum(m.schema == "foxglove.CompressedImage" for m in found) == 2


def test_a_scan_is_a_laser_scan_in_the_robot_s_frame(tmp_path: Path) -> None:
    ranges = np.array([1.0, math.inf, 2.5], np.float32)
    scan = Scan(-0.5, 0.5, 0.1, 10.0, ranges)
    with LogWriter(tmp_path / "scan.lcmlog") as log:
        log.write("robot.scan", 200_000, encode(scan, 200_000, 0))
    assert main(["export", str(tmp_path / "scan.lcmlog"), "--to", "mcap", "-o", str(tmp_path / "scan.mcap")]) == 0
    (found,) = [one for one in read(tmp_path / "scan.mcap") if one.topic == "/robot/scan/beams"]
    assert (found.schema, found.log_time) == ("foxglove.LaserScan", 200_000_000)
    assert found.message.frame_id == "robot"
    assert (found.message.start_angle, found.message.end_angle) == (-0.5, 0.5)
    assert list(found.message.ranges) == [1.0, math.inf, 2.5]
