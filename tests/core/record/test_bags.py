"""ROS 2 bags, written by their own library, are read as logs; what is wrong with one is told in a line."""

from __future__ import annotations

import io
import math
import os
import random
import struct
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image as Picture

from graphnav import Image, Odometry, Scan, Twist
from graphnav.arrays import Bytes
from graphnav.core.errors import BagError, LogError, UserError
from graphnav.core.record import Recording
from tests.ros_bags import Sent, compressed, file_of, header, image, make, odometry, twist, write_bag

START_US = 1_700_000_000_000_000
GRAY = np.arange(12, dtype=np.uint8).reshape(3, 4)
COLOURS = np.random.default_rng(1).integers(0, 256, (3, 4, 3), np.uint8)
ALPHA = np.full((3, 4, 1), 7, np.uint8)
BGR = COLOURS[:, :, ::-1]


def only_message(folder: Path) -> Any:
    with Recording(folder) as recording:
        ((_, _, message),) = recording.messages("/topic")
        return message


@pytest.mark.parametrize(
    ("encoding", "pixels", "expected"),
    [
        ("mono8", GRAY, GRAY),
        ("8UC1", GRAY, GRAY),
        ("rgb8", COLOURS, COLOURS),
        ("bgr8", BGR, COLOURS),
        ("rgba8", np.concatenate([COLOURS, ALPHA], 2), COLOURS),
        ("bgra8", np.concatenate([BGR, ALPHA], 2), COLOURS),
    ],
)
@pytest.mark.parametrize("padding", [0, 3])
def test_images_of_every_encoding(tmp_path: Path, encoding: str, pixels: Bytes, expected: Bytes, padding: int) -> None:
    sent = image(np.ascontiguousarray(pixels), encoding, START_US, padding)
    message = only_message(write_bag(tmp_path / "bag", [Sent("/topic", sent, START_US)]))
    assert isinstance(message, Image)
    assert message.step_px == 1
    np.testing.assert_array_equal(message.pixels, expected)


@pytest.mark.parametrize("kind", ["png", "jpeg"])
@pytest.mark.parametrize("pixels", [np.full((16, 24), 90, np.uint8), np.full((16, 24, 3), (200, 90, 10), np.uint8)])
def test_compressed_images(tmp_path: Path, kind: str, pixels: Bytes) -> None:
    data = io.BytesIO()
    Picture.fromarray(pixels).save(data, kind)
    message = only_message(write_bag(tmp_path / "bag", [Sent("/topic", compressed(data.getvalue(), kind), START_US)]))
    assert message.pixels.shape == pixels.shape
    np.testing.assert_allclose(message.pixels, pixels, atol=0 if kind == "png" else 2)  # one colour: JPEG rounds it


def test_velocities_scans_and_odometry(tmp_path: Path) -> None:
    ranges = np.array([1.0, math.inf, math.nan, 0.25], np.float32)
    scan = make(
        "sensor_msgs/LaserScan",
        header=header(START_US),
        angle_min=-0.5,
        angle_max=0.25,
        angle_increment=0.25,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.125,
        range_max=8.0,
        ranges=ranges,
        intensities=np.zeros(0, np.float32),
    )
    stamped = make("geometry_msgs/TwistStamped", header=header(START_US), twist=twist(-0.25, 0.75))
    folder = write_bag(
        tmp_path / "bag",
        [
            Sent("/scan", scan, START_US),
            Sent("/cmd_vel", twist(0.5, -0.125), START_US, 7),
            Sent("/stamped", stamped, START_US, 9),
            Sent("/odom", odometry((1.5, -2.5, 3.0), START_US), START_US, 11),
        ],
    )
    with Recording(folder) as recording:
        read = {name: recording.message(name, 0) for name in recording.channels}
        assert recording.begin_us == START_US
    for topic, utime, speeds in (("/cmd_vel", START_US + 7, (0.5, -0.125)), ("/stamped", START_US, (-0.25, 0.75))):
        command = read[topic][2]
        assert isinstance(command, Twist)
        assert (read[topic][:2], (command.v_mps, command.omega_radps)) == ((utime, 0), speeds)  # the first has no stamp
    found = read["/scan"][2]
    assert isinstance(found, Scan)
    assert (found.angle_min_rad, found.angle_increment_rad) == (-0.5, 0.25)
    assert (found.range_min_m, found.range_max_m) == (0.125, 8.0)
    np.testing.assert_array_equal(found.ranges_m, ranges)
    pose = read["/odom"][2]
    assert isinstance(pose, Odometry)
    assert (pose.x_m, pose.y_m, pose.v_mps, pose.omega_radps) == (1.5, -2.5, 0.3, 0.1)
    assert pose.yaw_rad == pytest.approx(3.0, abs=1e-15)


@pytest.mark.parametrize("yaw", [-3.1, -1.0, 0.0, 2.0, 3.1])
def test_the_heading_of_a_tilted_robot(tmp_path: Path, yaw: float) -> None:
    """A rotation by the yaw about z, then by a pitch about y, has that yaw; any length of the quaternion has."""
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(0.1), math.sin(0.1)
    turn = tuple(-1.5 * part for part in (-sy * sp, cy * sp, sy * cp, cy * cp))
    message = only_message(write_bag(tmp_path / "bag", [Sent("/topic", odometry((0, 0, 0), 0, turn), START_US)]))
    assert message.yaw_rad == pytest.approx(yaw, abs=1e-12)


def drive(folder: Path, storage: str = "mcap", compression: str = "", *, little_endian: bool = True) -> Path:
    """Write half a minute of pictures, odometry and something else, where several are recorded at once."""
    sent = []
    for k in range(60):
        utime = START_US + 500_000 * k
        sent.append(Sent("/odom", odometry((0.1 * k, 0.0, 0.01 * k), utime), utime, 2_000))
        sent.append(Sent("/camera", image(np.full((3, 4), k, np.uint8), "mono8", utime), utime, 2_000))
        sent.append(Sent("/camera", image(np.full((3, 4), 100 + k, np.uint8), "mono8", utime + 1), utime, 2_000))
        sent.append(Sent("/lamp", make("std_msgs/Bool", data=True), utime, 2_000))
    return write_bag(folder, sent, storage, compression, [("/never", "nav_msgs/msg/Path")], little_endian=little_endian)


@pytest.mark.parametrize(
    ("storage", "compression"),
    [("mcap", ""), ("mcap", "chunk"), ("mcap", "message"), ("sqlite3", ""), ("sqlite3", "message")],
)
def test_any_message_can_be_read_in_any_order(tmp_path: Path, storage: str, compression: str) -> None:
    folder = drive(tmp_path / "bag", storage, compression)
    with Recording(folder) as recording:
        assert recording.n_events == 240
        assert recording.n_bytes == file_of(folder).stat().st_size
        assert recording.utimes("/odom") == [START_US + 500_000 * k for k in range(60)]
        assert recording.event_utimes("/odom") == [START_US + 500_000 * k + 2_000 for k in range(60)]
        assert recording.foreign_types == {"/lamp": "std_msgs/msg/Bool"}
        events = list(recording.events())
        numbers = list(range(240))
        random.Random(1).shuffle(numbers)
        assert [recording.at(number) for number in numbers] == [events[number] for number in numbers]
        assert [head.seq for head in recording.heads() if head.channel == "/camera"] == list(range(120))
        levels = [int(one.pixels[0, 0]) for _, _, one in recording.messages("/camera") if isinstance(one, Image)]
        assert levels == [level for k in range(60) for level in (k, 100 + k)]


def test_two_threads_may_read(tmp_path: Path) -> None:
    """As the full screen of ``spy`` does: one reads on, while another looks at single messages."""
    with Recording(drive(tmp_path / "bag")) as recording:
        events = list(recording.events())
        with ThreadPoolExecutor(2) as pool:
            onward, back = pool.map(lambda order: [recording.at(k) for k in order], (range(240), range(239, -1, -1)))
    assert onward == events
    assert back == events[::-1]


def test_messages_without_bytes(tmp_path: Path) -> None:
    empty = Sent("/topic", PICTURE, START_US, raw=b"\0")
    folder = write_bag(tmp_path / "bag", [empty, empty, Sent("/topic", PICTURE, START_US)])
    with Recording(folder) as recording:
        assert [len(event.data) for event in recording.events()][:2] == [1, 1]
        assert recording.message("/topic", 2)[1] == 2
    assert fault(folder).startswith("is not sensor_msgs/msg/Image: ")


def test_a_file_of_a_bag_and_the_other_byte_order(tmp_path: Path) -> None:
    little, big = drive(tmp_path / "little"), drive(tmp_path / "big", "sqlite3", little_endian=False)
    with Recording(little) as one, Recording(file_of(big)) as other:
        of_types = [name for name in one.channels if name != "/lamp"]
        assert of_types == ["/odom", "/camera"]
        for name in of_types:
            assert [one.event(name, k) for k in range(60)] == [other.event(name, k) for k in range(60)]


def test_a_bag_of_several_files(tmp_path: Path) -> None:
    folder, later = (
        write_bag(
            tmp_path / name, [Sent("/odom", odometry((k, 0, 0), k * 1_000_000), k * 1_000_000) for k in range(*of)]
        )
        for name, of in (("bag", (1, 4)), ("later", (4, 9)))
    )
    file_of(later).rename(folder / "later.mcap")
    metadata = folder / "metadata.yaml"
    text = metadata.read_text().replace("  - bag.mcap\n", "  - /elsewhere/bag.mcap\n  - later.mcap\n")
    metadata.write_text(text.replace("message_count: 3", "message_count: 8"))
    with Recording(folder) as recording:
        assert [one.x_m for _, _, one in recording.messages("/odom") if isinstance(one, Odometry)] == [*range(1, 9)]
        assert recording.message("/odom", 1)[0] == 2_000_000


def refusal(path: Path) -> str:
    """Return the text of the error, which ends a command with exit status 2, without the folder of the test."""
    with pytest.raises(BagError) as raised:
        Recording(path)
    assert isinstance(raised.value, UserError | LogError)
    return str(raised.value).replace(f"{path.parent}/", "").replace(f"{path.parent.parent}/", "")


CUT = "if its recording was cut off, repair it"


def test_files_that_are_not_bags(tmp_path: Path) -> None:
    file = tmp_path / "a.mcap"
    file.write_bytes(b"")
    repair = f"{CUT}: mcap recover {file} -o repaired.mcap".replace(f"{tmp_path}/", "")
    cannot = "a.mcap cannot be read as a ROS 2 bag"
    assert refusal(file) == f"{cannot}: File 'a.mcap' seems to be empty\n  {repair}"
    file.write_bytes(b"no bag")
    assert refusal(file) == f"{cannot}: File magic is invalid\n  {repair}"
    intact = file_of(drive(tmp_path / "bag")).read_bytes()
    file.write_bytes(intact[: len(intact) // 2])
    assert refusal(file) == f"{cannot}: File end magic is invalid\n  {repair}"
    file.write_bytes(intact.replace(b"\x04\x00\x00\x00ros2", b"\x04\x00\x00\x00josx", 1))
    only = "only the MCAP files of ROS 2 can be read: record it with 'ros2 bag record'"
    assert refusal(file) == f"{cannot}: Profile is not ros2\n  {only}"
    file = tmp_path / "a.db3"
    repair = f"{CUT}: sqlite3 a.db3 .recover"
    file.write_bytes(b"longer than the header of a database" * 9)
    cannot = "a.db3 cannot be read as a ROS 2 bag: Cannot open database a.db3:"
    assert refusal(file) == f"{cannot} file is not a database\n  {repair}"
    intact = file_of(drive(tmp_path / "sql", "sqlite3")).read_bytes()
    file.write_bytes(intact[: len(intact) // 2])
    assert refusal(file) == f"{cannot} database disk image is malformed\n  {repair}"


LIES = [
    (
        "rosbag2_bagfile_information",
        "other",
        (
            "it does not describe a ROS 2 bag: there is no 'rosbag2_bagfile_information'\n"
            "  name a folder that 'ros2 bag record' has written, or one of its files"
        ),
    ),
    (
        "- bag.mcap",
        "- 7",
        "'relative_file_paths' does not list the files of the bag\n  write the metadata again: ros2 bag reindex FOLDER",
    ),
    (
        "compression_mode: ''",
        "compression_mode: FILE",
        (
            "compression_mode 'file' cannot be read\n"
            "  expand its files (zstd -d), and name one of them in place of the folder"
        ),
    ),
    (
        "compression_mode: ''",
        "compression_mode: message",
        "compression_format '' cannot be read\n  write it again: ros2 bag convert",
    ),
    (
        "message_count: 60",
        "message_count: 61",
        (
            "its metadata tell of 61 messages on /odom, but the files hold 60\n"
            "  copy the bag again, or read a file of it: bag/bag.mcap"
        ),
    ),
]
"""The metadata, what is put in their place, and the error."""


@pytest.mark.parametrize(("was", "becomes", "expected"), LIES)
def test_metadata_that_lie(tmp_path: Path, was: str, becomes: str, expected: str) -> None:
    metadata = drive(tmp_path / "bag") / "metadata.yaml"
    text = metadata.read_text()
    assert was in text
    metadata.write_text(text.replace(was, becomes, 1))
    assert refusal(tmp_path / "bag") == f"bag/metadata.yaml: {expected}"


def test_files_that_are_missing(tmp_path: Path) -> None:
    folder = drive(tmp_path / "bag")
    file_of(folder).unlink()
    text = "bag/bag.mcap: No such file or directory\n  copy the bag again, with all its files"
    assert refusal(folder) == text
    os.mkfifo(folder / "bag.mcap")
    assert refusal(folder) == text.replace("No such file or directory", "it is a FIFO, not a regular file")
    (folder / "metadata.yaml").write_text("[")
    assert refusal(folder).startswith("bag/metadata.yaml:1:2: ")


def patched(was: int, becomes: int) -> Callable[[bytes], bytes]:
    return lambda data: data.replace(struct.pack("<Q", was), struct.pack("<Q", becomes))


def test_chunks_that_claim_another_size(tmp_path: Path) -> None:
    """Neither memory for what a chunk claims is taken, nor for what it expands to beyond that."""
    folder = drive(tmp_path / "bag", compression="chunk")
    file = file_of(folder)
    with Recording(folder) as recording:
        assert recording.bag is not None
        (chunk,) = recording.bag._folder.files[0]._reader.storage.chunks  # the sizes as the file has them
    n_bytes, intact = chunk.uncompressed_size, file.read_bytes()
    cannot = "bag.mcap cannot be read as a ROS 2 bag"
    repair = f"{CUT}: mcap recover bag.mcap -o repaired.mcap"
    file.write_bytes(patched(n_bytes, 10 * 10**9)(intact))
    claims = "ValueError: a chunk declares 10000000000 bytes, more than the maximum of 1073741824"
    assert refusal(file) == f"{cannot}: {claims}\n  {repair}"
    file.write_bytes(patched(n_bytes, 1000)(intact))
    assert refusal(file) == f"{cannot}: Chunk size mismatch: expected 1000 bytes, got 1001\n  {repair}"


def fault(folder: Path) -> str:
    with Recording(folder) as recording, pytest.raises(LogError) as raised:
        recording.message("/topic", 0)
    return str(raised.value).removeprefix(f"{folder}: message 0 of topic '/topic': ")


PICTURE = image(GRAY, "mono8")
KNOWN = "mono8, 8UC1, rgb8, bgr8, rgba8, bgra8"


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (image(GRAY, "bayer_rggb8"), f"encoding is 'bayer_rggb8', expected {KNOWN}"),
        (image(GRAY, "mono16"), f"encoding is 'mono16', expected {KNOWN}"),
        (image(GRAY, "mono8", height=4), "size of data is 12, expected height * step = 4 * 4 = 16"),
        (image(GRAY, "rgb8"), "step is 4, expected 12 or more, the bytes of a row"),
        (image(GRAY, "mono8", width=0), "width is 0, expected 1 or more"),
        (image(GRAY, "mono8", height=10**5, width=10**5),
         "width * height is 100000 * 100000, expected 64 million at most"),
        (compressed(b"GIF89a", "gif"), "format is 'gif', expected JPEG or PNG"),
        (odometry((0.0, 0.0, 0.0), 0, (0.0, 0.0, 0.0, 0.0)), "pose.orientation is (0, 0, 0, 0), expected a rotation"),
    ],
)  # fmt: skip
def test_messages_that_cannot_be_read(tmp_path: Path, message: Any, expected: str) -> None:
    folder = write_bag(tmp_path / "bag", [Sent("/topic", message, START_US)])
    assert fault(folder) == expected


@pytest.mark.parametrize(("storage", "compression"), [("mcap", ""), ("mcap", "chunk"), ("sqlite3", "")])
def test_damage_at_any_place_is_told_in_a_line(tmp_path: Path, storage: str, compression: str) -> None:
    folder = drive(tmp_path / "bag", storage, compression)
    file = file_of(folder)
    intact, places = file.read_bytes(), random.Random(7)
    n_refused = 0
    for _ in range(25):
        data = bytearray(intact)
        for _ in range(places.choice((1, 4))):
            data[places.randrange(len(data))] = places.randrange(256)
        begin = places.randrange(len(data))
        data[begin : begin + places.choice((1, 8))] = bytes(places.choice((0, 8)))
        file.write_bytes(data)
        try:
            with Recording(folder) as recording:
                for number in range(recording.n_events):
                    recording.at(number)
        except BagError as error:
            n_refused += 1
            (problem,) = error.problems
            assert problem.hint
            assert "\n" not in problem.what
    assert n_refused


def test_bytes_that_are_not_of_the_type(tmp_path: Path) -> None:
    raw = bytes(range(40))
    folder = write_bag(tmp_path / "bag", [Sent("/topic", PICTURE, START_US, raw=raw)])
    assert fault(folder).startswith("is not sensor_msgs/msg/Image: ")
    assert "\n" not in fault(folder)
    with Recording(folder) as recording:
        assert recording.event("/topic", 0).data == raw


def test_a_png_of_16_bits_and_a_truncated_jpeg(tmp_path: Path) -> None:
    deep, flat = io.BytesIO(), io.BytesIO()
    Picture.fromarray(np.full((16, 24), 40_000, np.uint16)).save(deep, "png")
    folder = write_bag(tmp_path / "deep", [Sent("/topic", compressed(deep.getvalue(), "png"), START_US)])
    assert fault(folder) == "format is 'png' of more than 8 bits, expected JPEG or PNG of 8 bits"
    Picture.fromarray(np.random.default_rng(1).integers(0, 256, (64, 64), np.uint8)).save(flat, "jpeg")
    folder = write_bag(tmp_path / "cut", [Sent("/topic", compressed(flat.getvalue()[:900], "jpeg"), START_US)])
    assert fault(folder).startswith("its picture cannot be decoded: image file is truncated")


def test_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = drive(tmp_path / "bag")
    for name in [name for name in sys.modules if name.partition(".")[0] == "rosbags"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(UserError) as raised:
        Recording(folder)
    assert str(raised.value).startswith("a ROS 2 bag needs rosbags\n  pip install ")
