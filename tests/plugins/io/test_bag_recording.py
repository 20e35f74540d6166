"""A drive in a ROS 2 bag plays as the same drive in a log: pictures, motion, and what graphs make of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from graphnav_io.recording import Drive, Recording

from graphnav import Finished, ParamError, Plane, Stamp
from graphnav.core.api.run import run
from graphnav.core.cli import main
from graphnav.core.record import Recording as Log
from tests.ros_bags import Sent, file_of, image, make, odometry, write_bag

START_US = 1_700_000_000_000_000
PICTURE = np.zeros((24, 32), np.uint8)


ROBOT = """\
run: {until_s: 2, seed: 3, record: replayable}
stages:
  robot:  {use: world.robot, with: {map: maps/corridor_ccw.yaml, image_jitter_s: 0.01}, in: {command: driver.twist}}
  driver: {use: control.wander, in: {image: robot.image}}
"""
"""A robot whose pictures come every 0.1 s, give or take 10 ms, and its odometry at 50 Hz."""


@pytest.fixture(scope="module")
def drives(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return the log of a drive of two seconds, and the two kinds of bag that it is exported to."""
    folder = tmp_path_factory.mktemp("drive")
    (folder / "robot.yaml").write_text(ROBOT)
    words = ["run", str(folder / "robot.yaml"), "--no-tap", "--no-pictures", "-o", str(folder / "run")]
    assert main(words) == 0
    paths = {"log": folder / "run" / "run.lcmlog", "mcap": folder / "mcap", "sqlite3": folder / "sqlite3"}
    for storage in ("mcap", "sqlite3"):
        export = ["export", str(paths["log"]), "--to", "rosbag2", "--storage", storage, "-o", str(paths[storage])]
        assert main([*export, "--channel", "robot.image", "--channel", "robot.odometry"]) == 0
    return paths


def play(source: Recording) -> list[tuple[int, Drive]]:
    """Return what a source publishes when it is fired when it is due."""
    source.check()
    source.reset(0)
    played: list[tuple[int, Drive]] = []
    try:
        while True:
            utime = source.due_us(len(played))
            played.append((utime, source.step(Stamp(utime))))
    except Finished as finished:
        played.append((utime, finished.outputs))
    finally:
        source.close()
    return played


def test_a_bag_plays_as_the_log_does(drives: dict[str, Path]) -> None:
    logged = play(Recording(path=drives["log"]))
    assert len(logged) >= 20
    assert len({utime % 100_000 for utime, _ in logged}) > 1, "the pictures come when they come"
    for path in (drives["mcap"], file_of(drives["mcap"]), drives["sqlite3"], file_of(drives["sqlite3"])):
        played = play(Recording(path=path))
        assert [utime for utime, _ in played] == [utime for utime, _ in logged]
        for (_, one), (_, other) in zip(played[1:], logged[1:], strict=True):
            np.testing.assert_array_equal(one.image.pixels, other.image.pixels)
            found, expected = one.motion, other.motion
            if found is None or expected is None:
                assert found is expected
                continue
            assert found.interval_us == expected.interval_us
            # the heading is rounded as a quaternion
            assert (found.forward_m, found.left_m) == pytest.approx((expected.forward_m, expected.left_m), abs=1e-12)
            assert found.turn_rad == pytest.approx(expected.turn_rad, abs=1e-12)


def planes(graph: str, folder: Path, swaps: dict[str, object]) -> list[Plane]:
    run(graph, set=swaps, folder=folder, pictures=False, record="all", check=True)
    with Log(folder / "run.lcmlog") as log:
        return [plane for _, _, plane in log.messages("plane.plane") if isinstance(plane, Plane)]


@pytest.mark.parametrize(
    ("graph", "swaps"),
    [
        ("video_plane", {"camera": "io.recording", "camera.crop_top_ratio": 0.0, "camera.path": ""}),
        ("navigate_recorded", {"drive.path": ""}),
    ],
)
def test_a_graph_sees_in_a_bag_what_it_sees_in_the_log(
    drives: dict[str, Path], tmp_path: Path, graph: str, swaps: dict[str, object]
) -> None:
    path = next(name for name in swaps if name.endswith(".path"))
    logged, bagged, stored = (
        planes(graph, tmp_path / name, swaps | {path: str(drives[name])}) for name in ("log", "mcap", "sqlite3")
    )
    assert len(logged) >= 19
    for found in (bagged, stored):
        for one, other in zip(found, logged, strict=True):
            np.testing.assert_array_equal(one.obstacle, other.obstacle)
            np.testing.assert_array_equal(one.valid, other.valid)
            np.testing.assert_allclose(one.score, other.score, rtol=1e-5, atol=1e-6)


def refusal(**parameters: Any) -> str:
    with pytest.raises(ParamError) as raised:
        Recording(**parameters).check()
    folder = Path(parameters["path"]).parent
    return str(raised.value).replace(f"{folder}/", "")


def pictures(topic: str, encoding: str = "mono8") -> list[Sent]:
    stamps = [START_US + 100_000 * k for k in range(3)]
    return [Sent(topic, image(PICTURE, encoding, stamp), stamp) for stamp in stamps]


def poses(topic: str, count: int = 3, step_us: int = 100_000) -> list[Sent]:
    stamps = [START_US + step_us * k for k in range(count)]
    return [Sent(topic, odometry((0.01 * k, 0.0, 0.0), stamp), stamp) for k, stamp in enumerate(stamps)]


def test_topics_are_chosen_by_their_type_or_by_name(tmp_path: Path) -> None:
    sent = [*pictures("/left"), *pictures("/right"), *poses("/wheels"), *poses("/slam"), *poses("/still", 1)]
    bag = write_bag(tmp_path / "bag", sent, silent=[("/rear", "sensor_msgs/msg/Image")])
    assert refusal(path=bag) == ("image_channel: 'bag' has 2 topics of Image\n  its topics of Image are /left, /right")
    assert refusal(path=bag, image_channel="/rear") == (
        "image_channel: 'bag' has no topic '/rear' of Image\n  its topics of Image are /left, /right"
    )
    assert refusal(path=bag, image_channel="/left") == (
        "odometry_channel: 'bag' has 3 topics of Odometry\n  its topics of Odometry are /wheels, /slam, /still"
    )
    assert refusal(path=bag, image_channel="/left", odometry_channel="/still") == (
        "odometry: 'bag' holds a single sample\n  record the drive, at 10 Hz or more"
    )
    played = play(Recording(path=bag, image_channel="/left", odometry_channel="/slam"))
    assert [drive.motion.forward_m for _, drive in played if drive.motion] == pytest.approx([0.01, 0.01])
    played = play(Recording(path=bag, image_channel="/left", odometry=bag, odometry_channel="/wheels"))
    assert [drive.motion is None for _, drive in played] == [True, False, False]


def test_a_bag_without_what_is_needed(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "lamp", [Sent("/lamp", make("std_msgs/Bool", data=True), START_US)])
    assert refusal(path=bag) == (
        "image_channel: 'lamp' has no topics of Image\n"
        "  its topics of Image are none; it holds /lamp (std_msgs/msg/Bool)"
    )
    only = write_bag(tmp_path / "only", pictures("/camera"))
    assert [drive.motion for _, drive in play(Recording(path=only))] == [None, None, None]
    assert refusal(path=only, odometry_channel="/odom") == (
        "odometry_channel: 'only' has no topic '/odom' of Odometry\n"
        "  its topics of Odometry are none; it holds /camera (sensor_msgs/msg/Image)"
    )
    raw = write_bag(tmp_path / "raw", pictures("/camera", "bayer_rggb8"))
    assert refusal(path=raw) == (
        "path: raw: message 0 of topic '/camera': encoding is 'bayer_rggb8', "
        "expected mono8, 8UC1, rgb8, bgr8, rgba8, bgra8"
    )
    file = tmp_path / "a.mcap"
    file.write_bytes(b"no bag")
    assert refusal(path=file) == (
        "path: a.mcap cannot be read as a ROS 2 bag: File magic is invalid\n"
        "  if its recording was cut off, repair it: mcap recover a.mcap -o repaired.mcap"
    )
    missing = "path: missing.mcap: No such file or directory\n  give an LCM log (.lcmlog) or a ROS 2 bag"
    assert refusal(path=tmp_path / "missing.mcap") == missing


def test_parameters_that_a_log_does_not_take(drives: dict[str, Path], tmp_path: Path) -> None:
    bag = drives["mcap"]
    for name, value in (("rate_hz", 5.0), ("start_s", 2.0), ("times", Path("times.csv"))):
        assert refusal(path=bag, **{name: value}) == (
            f"{name}: '{name}' is {value}, but 'mcap' has the times of its pictures\n  remove it"
        )
    assert refusal(path=tmp_path / "frames", image_channel="/camera") == (
        "image_channel: 'image_channel' is '/camera', but 'frames' is not a log\n"
        "  remove it, or give a log or a ROS 2 bag as 'path'"
    )


def test_pictures_of_one_stamp_and_in_another_order(tmp_path: Path) -> None:
    stamps = [START_US, START_US + 200_000, START_US + 100_000, START_US + 100_000]
    sent = [Sent("/c", image(PICTURE + k, "mono8", stamp), START_US + k) for k, stamp in enumerate(stamps)]
    played = play(Recording(path=write_bag(tmp_path / "bag", sent)))
    assert [(utime, int(drive.image.pixels[0, 0])) for utime, drive in played] == [(0, 0), (100_000, 2), (200_000, 1)]
